#include "clients/cli/commands/runs/run_watch.h"

#include <chrono>

#include "clients/cli/core/proto_json.h"
#include "clients/cli/pages/progress_bar.h"
#include "clients/cli/pages/run_text.h"
#include "driftwise/v1/cell_service.grpc.pb.h"
#include "driftwise/v1/run_service.grpc.pb.h"

namespace driftwise::cli {

namespace {

constexpr auto kBetweenLines = std::chrono::seconds(1);

// A line where the state has changed or the run is over; else at most one a second.
void tell_program(const Session& session, const v1::RunProgress& progress, std::string& told,
                  std::chrono::steady_clock::time_point& told_at) {
  const auto now = std::chrono::steady_clock::now();
  const std::string state = state_text(progress.run().state());
  if (state == told && !is_over(progress.run().state()) && now - told_at < kBetweenLines) return;
  told = state;
  told_at = now;
  session.console.out << json_from(progress).dump() << '\n' << std::flush;
}

}  // namespace

v1::Run watch_until_over(const Session& session, const Connection& connection,
                         std::optional<std::int64_t> run_id) {
  v1::WatchRunRequest request;
  if (run_id) request.set_run_id(*run_id);
  v1::Run run;
  try {
    const auto status = connection.ask(&v1::CellService::Stub::GetStatus, v1::GetStatusRequest{});
    ProgressBar bar(session.console, status);
    // A program wants to know of states and points; what lies between comes many times a second.
    std::string told;
    std::chrono::steady_clock::time_point told_at{};
    const std::function<bool(const v1::WatchRunResponse&)> on_progress =
        [&](const v1::WatchRunResponse& response) {
          run = response.progress().run();
          if (session.console.json)
            tell_program(session, response.progress(), told, told_at);
          else
            bar.show(response.progress());
          return true;
        };
    connection.follow(&v1::RunService::Stub::WatchRun, request, on_progress);
  } catch (Failure& failure) {
    const bool is_under_way = run.id() != 0 && !is_over(run.state());
    const std::string id = std::to_string(run.id());
    if (is_under_way && failure.reason == "NO_DAEMON")
      failure.message += "; run " + id +
                         " goes on when it starts, or waits for `driftwise run resume " + id +
                         "`, as [run] after_restart says";
    const bool left = failure.exit == ExitCode::interrupted || failure.reason == "TIMEOUT";
    if (left && is_under_way) {
      failure.message = (failure.exit == ExitCode::interrupted ? "interrupted" : "time is up") +
                        std::string(": run ") + id +
                        " goes on; look again with `driftwise run watch " + id +
                        "`, end it with `driftwise run abort " + id + "`";
    }
    throw;
  }
  return run;
}

}  // namespace driftwise::cli
