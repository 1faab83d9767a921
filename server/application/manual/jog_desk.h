#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <memory>
#include <optional>

#include "server/application/manual/jogs.h"
#include "server/application/motion/workbench.h"
#include "server/application/plumbing/task_group.h"
#include "server/application/runs/right_to_move.h"
#include "server/application/runs/run_engine.h"

namespace driftwise::application {

class JogDesk final : public Jogs {
 public:
  // by_wall: silence is measured on the wall clock, whatever the cell's does; false, in virtual
  // time: on the cell's. All of them outlive this.
  JogDesk(asio::any_io_executor executor, Workbench& bench, RunEngine& engine, RightToMove& right,
          const LeaseBook& leases, TaskGroup& tasks, bool by_wall);

  Awaitable<Result<JogState>> begin(Caller caller, std::string lease_token, JogOrder order,
                                    HoldAnswer answer) override;
  Result<JogState> hold(std::int64_t id, const std::string& lease_token) override;
  Awaitable<Result<JogState>> end(std::int64_t id, std::string lease_token) override;

 private:
  struct Jog;
  using JogPtr = std::shared_ptr<Jog>;

  Result<std::size_t> axis_of(const JogOrder& order) const;
  Result<void> hold_others(std::size_t axis, std::vector<double>& q_mm) const;
  Result<void> check_step(const std::vector<double>& from_mm, const std::vector<double>& to_mm,
                          const AxesToMove& moved) const;
  Result<JogPtr> find(std::int64_t id, const std::string& lease_token) const;
  Awaitable<void> carry(JogPtr jog);
  Awaitable<Result<void>> step_on(Jog& jog);
  Awaitable<Result<void>> arrive(Jog& jog, double from_mm);
  Awaitable<void> listen(JogPtr jog);  // for the client's signs of life
  Awaitable<void> halt(JogPtr jog, std::string why, bool released);
  Awaitable<void> stop_axes(Jog& jog);  // at rest, or a stop that is not forgotten
  Awaitable<bool> at_rest();
  std::chrono::nanoseconds wall_now() const;
  Awaitable<void> wall_sleep(std::chrono::nanoseconds duration);

  asio::any_io_executor executor_;
  Workbench& bench_;
  RunEngine& engine_;
  RightToMove& right_;
  const LeaseBook& leases_;
  TaskGroup& tasks_;
  bool by_wall_;
  std::int64_t last_id_ = 0;
  JogPtr jog_;  // under way, or the last one
};

}  // namespace driftwise::application
