#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <functional>

#include "server/application/plumbing/event_log.h"
#include "server/application/trajectories/trajectories.h"
#include "server/core/description/cell_description.h"

namespace driftwise::application {

class TrajectoriesService final : public Trajectories {
 public:
  // point_s: what a visit takes in this cell, now. All of them outlive this.
  TrajectoriesService(const CellDescription& description, Clock& clock, StoreWriter& writer,
                      EventLog& events, asio::any_io_executor background,
                      std::function<double()> point_s)
      : description_(description),
        clock_(clock),
        writer_(writer),
        events_(events),
        background_(std::move(background)),
        point_s_(std::move(point_s)) {}

  Awaitable<Result<TrajectoryCheck>> check(std::string name, std::string text) override;
  Awaitable<Result<KeptTrajectory>> keep(Caller caller, std::string name,
                                         std::string text) override;

 private:
  const CellDescription& description_;
  Clock& clock_;
  StoreWriter& writer_;
  EventLog& events_;
  asio::any_io_executor background_;
  std::function<double()> point_s_;
};

}  // namespace driftwise::application
