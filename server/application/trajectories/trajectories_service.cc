#include "server/application/trajectories/trajectories_service.h"

#include <fmt/format.h>

#include "server/application/plumbing/run_on.h"
#include "server/application/trajectories/trajectory_check.h"
#include "server/core/try.h"
#include "server/formats/text/text.h"

namespace driftwise::application {

Awaitable<Result<TrajectoryCheck>> TrajectoriesService::check(std::string name, std::string text) {
  using History = std::shared_ptr<const DurationHistory>;
  co_return co_await run_on(
      background_,
      [cell = &description_](const std::string& file, const std::string& csv,
                             const History& history) {
        return check_trajectory_text(*cell, file, csv, *history);
      },
      name, text, durations_.history());
}

Awaitable<Result<KeptTrajectory>> TrajectoriesService::keep(Caller caller, std::string name,
                                                            std::string text) {
  DRIFTWISE_CO_TRY(const auto checked, co_await check("trajectory", text));
  KeptTrajectory wanted;
  wanted.name = name;
  wanted.text = text;
  wanted.hash = formats::content_hash(text);
  wanted.rows = static_cast<std::int64_t>(checked.trajectory.points.size());
  wanted.created = clock_.now().utc;
  wanted.created_by = caller.name;
  auto kept = co_await writer_.trajectories().keep(wanted);
  if (kept && kept->created.utc_ns == wanted.created.utc_ns)
    events_.record(caller, "trajectory.kept",
                   fmt::format("trajectory {} '{}', {} rows", kept->id.value, name, wanted.rows));
  co_return kept;
}

}  // namespace driftwise::application
