#pragma once

#include <boost/asio/any_io_executor.hpp>

#include "server/application/plumbing/event_log.h"
#include "server/application/trajectories/duration_book.h"
#include "server/application/trajectories/trajectories.h"
#include "server/core/description/cell_description.h"

namespace driftwise::application {

class TrajectoriesService final : public Trajectories {
 public:
  // All of them outlive this.
  TrajectoriesService(const CellDescription& description, Clock& clock, StoreWriter& writer,
                      EventLog& events, asio::any_io_executor background,
                      const DurationBook& durations)
      : description_(description),
        clock_(clock),
        writer_(writer),
        events_(events),
        background_(std::move(background)),
        durations_(durations) {}

  Awaitable<Result<TrajectoryCheck>> check(std::string name, std::string text) override;
  Awaitable<Result<KeptTrajectory>> keep(Caller caller, std::string name,
                                         std::string text) override;

 private:
  const CellDescription& description_;
  Clock& clock_;
  StoreWriter& writer_;
  EventLog& events_;
  asio::any_io_executor background_;
  const DurationBook& durations_;
};

}  // namespace driftwise::application
