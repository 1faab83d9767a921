#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <functional>

#include "server/application/manual/manual_control.h"
#include "server/application/motion/loading.h"
#include "server/application/motion/stop_events.h"
#include "server/application/motion/workbench.h"
#include "server/application/plumbing/store_reader.h"
#include "server/application/plumbing/task_group.h"
#include "server/application/recording/doubts.h"
#include "server/application/runs/right_to_move.h"
#include "server/application/runs/run_engine.h"
#include "server/application/serving/serving.h"

namespace driftwise::application {

class ManualControlService final : public ManualControl {
 public:
  // on_stop: called at every stop, with a sentence that says whose. All of them outlive this.
  ManualControlService(asio::any_io_executor executor, Workbench& bench, StoreReader& reader,
                       RunEngine& engine, RightToMove& right, LeaseBook& leases,
                       StopEvents& stop_events, Serving& serving, TaskGroup& tasks,
                       std::function<void(const std::string&)> on_stop);
  // Before any device is asked: refuses motion while a stop is pending, watches for motion that
  // nobody commanded.
  void start();

  Result<Lease> take_lease(const Caller& caller, Nanoseconds duration,
                           const std::string& token) override;
  Result<void> give_up_lease(const Caller& caller, const std::string& token) override;
  Awaitable<Result<StopAnswer>> stop_all(Caller caller) override;
  Awaitable<Result<void>> home(Caller caller, std::string lease_token, HoldAnswer answer) override;
  Awaitable<Result<void>> move_to(Caller caller, std::string lease_token, std::vector<double> q_mm,
                                  HoldAnswer answer) override;
  Awaitable<Result<void>> set_stabiliser(Caller caller, std::string lease_token, std::string device,
                                         double degc) override;
  Awaitable<Result<DeclaredTuning>> stabiliser_tuning(std::string device) override;
  Awaitable<Result<TunedStabiliser>> tune_stabiliser(Caller caller, std::string lease_token,
                                                     std::string device,
                                                     LoopTuning wanted) override;

  // Poses and targets count from it now.
  void take_datum(const DatumRecord& datum);
  // Sentences; empty: nothing. What a movement by hand waits for; motion without a command, until a
  // datum is opened; axes that were homed, without a datum since.
  const std::string& waits() const { return waits_; }
  const std::string& motion_trouble() const { return motion_trouble_; }
  const std::string& datum_trouble() const { return datum_trouble_; }

 private:
  Result<std::size_t> stabiliser_named(const std::string& device) const;
  class ByHand;
  Awaitable<Result<DatumRecord>> new_datum_by_hand(RunScope& scope, std::string reason);
  Awaitable<Result<void>> ask_devices_of_datum(RunScope& scope);
  Awaitable<Result<DatumRecord>> datum_where_homed(RunScope& scope, std::string reason);
  // False also where no pose is measured, or none counts from a datum.
  Awaitable<bool> axes_measured_at(std::vector<double> q_mm);
  void motion_found(const MotionFinding& found);
  Awaitable<void> halt_axes();
  Awaitable<void> press_where_it_moves_on(Caller caller, Error ended);

  asio::any_io_executor executor_;
  Workbench& workbench_;
  const CellDescription& description_;
  Clock& clock_;
  DeviceBench& bench_;
  Recorder& recorder_;
  EventLog& events_;
  PoseStage& pose_;
  Loading& loading_;
  StopDesk& stops_;
  Doubts& doubts_;
  StoreReader& reader_;
  RunEngine& engine_;
  RightToMove& right_;
  LeaseBook& leases_;
  StopEvents& stop_events_;
  Serving& serving_;
  TaskGroup& tasks_;
  std::function<void(const std::string&)> on_stop_;
  std::string waits_, motion_trouble_, datum_trouble_;
};

}  // namespace driftwise::application
