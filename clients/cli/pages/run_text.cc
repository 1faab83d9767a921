#include "clients/cli/pages/run_text.h"

#include <algorithm>

#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "clients/cli/pages/band_text.h"
#include "clients/cli/pages/configuration_text.h"
#include "clients/cli/pages/metadata_text.h"

namespace driftwise::cli {
namespace {

std::string painted_state(const Paint& paint, v1::Run::State state) {
  const std::string text = state_text(state);
  if (state == v1::Run::STATE_DONE) return paint.good(text);
  if (state == v1::Run::STATE_FAILED || state == v1::Run::STATE_ABORTED) return paint.bad(text);
  if (state == v1::Run::STATE_PAUSED || state == v1::Run::STATE_WAITING) return paint.warn(text);
  return text;
}

// "correction 3, 5": of the data that exports and fits see.
std::string rests_on(const v1::Run& run) {
  std::string text;
  for (const auto& mark : run.corrections())
    text += (text.empty() ? "correction " : ", ") + std::to_string(mark.correction_id());
  return text;
}

}  // namespace

std::string state_text(v1::Run::State state) {
  switch (state) {
    case v1::Run::STATE_QUEUED:
      return "queued";
    case v1::Run::STATE_RUNNING:
      return "running";
    case v1::Run::STATE_PAUSED:
      return "paused";
    case v1::Run::STATE_WAITING:
      return "waiting";
    case v1::Run::STATE_DONE:
      return "done";
    case v1::Run::STATE_ABORTED:
      return "aborted";
    case v1::Run::STATE_FAILED:
      return "failed";
    default:
      return "unknown";
  }
}

bool is_over(v1::Run::State state) {
  return state == v1::Run::STATE_DONE || state == v1::Run::STATE_ABORTED ||
         state == v1::Run::STATE_FAILED;
}

ExitCode exit_code_of(v1::Run::State state) {
  return state == v1::Run::STATE_ABORTED || state == v1::Run::STATE_FAILED ? ExitCode::refused
                                                                           : ExitCode::done;
}

std::string compensation_text(const v1::Run& run) {
  if (!run.compensated()) return "uncompensated";
  if (run.has_compensate_plan_id())
    return "compensated by plan " + std::to_string(run.compensate_plan_id());
  return run.has_compensate_model_id()
             ? "compensated with model " + std::to_string(run.compensate_model_id())
             : "compensated with the model that served";
}

void print_runs(const Console& console, const std::vector<v1::Run>& runs,
                const std::vector<std::string>& wanted) {
  if (runs.empty() && !wanted.empty()) {
    console.out << "no run matches";
    for (const auto& one : wanted) console.out << " --meta " << one;
    console.out << ": driftwise run list shows all\n";
    return;
  }
  if (runs.empty()) {
    console.out << "no runs yet: driftwise run start TRAJECTORY.csv\n";
    return;
  }
  std::vector<Table::Column> columns({{"run", Align::right},
                                      {"name"},
                                      {"state"},
                                      {"points", Align::right},
                                      {"given up", Align::right},
                                      {"attempts", Align::right},
                                      {"started (UTC)"},
                                      {"took", Align::right},
                                      {"compensated"},
                                      {"operator"},
                                      {"rests on"}});
  if (std::ranges::any_of(runs, [](const v1::Run& run) { return run.metadata_size() > 0; }))
    columns.push_back({"metadata"});
  const bool has_setups =
      std::ranges::any_of(runs, [](const v1::Run& run) { return !run.setup().empty(); });
  if (has_setups) columns.insert(columns.begin() + 2, {"set-up"});
  Table table(std::move(columns));
  for (const auto& run : runs) {
    std::vector<Table::Cell> row = {
        std::to_string(run.id()),
        run.name(),
        state_text(run.state()),
        std::to_string(run.accepted_count()) + "/" + std::to_string(run.row_count()),
        std::to_string(run.given_up_count()),
        std::to_string(run.attempt_count()),
        run.has_start_time() ? clock_text(run.start_time()) : "-",
        run.has_elapsed_duration() ? span_text(seconds_of(run.elapsed_duration())) : "-",
        !run.compensated()              ? "no"
        : run.has_compensate_plan_id()  ? "plan " + std::to_string(run.compensate_plan_id())
        : run.has_compensate_model_id() ? "model " + std::to_string(run.compensate_model_id())
                                        : "yes",
        run.operator_name(),
        rests_on(run),
        metadata_text(run.metadata())};
    if (has_setups) row.insert(row.begin() + 2, run.setup());
    table.add(std::move(row));
  }
  table.print(console.out, console.paint_out());
}

void print_run(const Console& console, const v1::Run& run) {
  const Paint paint = console.paint_out();
  const auto line = [&](const std::string& name, const std::string& value) {
    console.out << paint.dim(name + std::string(name.size() < 14 ? 14 - name.size() : 1, ' '))
                << value << '\n';
  };
  line("run", std::to_string(run.id()) + "  " + run.name());
  line("state", painted_state(paint, run.state()) +
                    (run.reason().empty() ? "" : "  (" + run.reason() + ")"));
  line("trajectory", run.trajectory_name() + (run.trajectory_name().empty() ? "" : ", ") +
                         std::to_string(run.row_count()) + " rows");
  if (!run.setup().empty()) line("set-up", run.setup());
  line("compensation", compensation_text(run));
  line("points", std::to_string(run.accepted_count()) + " accepted, " +
                     std::to_string(run.given_up_count()) + " given up, " +
                     std::to_string(run.attempt_count()) + " attempts");
  line("operator", run.operator_name());
  if (!run.metadata().empty()) line("metadata", metadata_text(run.metadata()));
  if (run.has_queue_entry_id()) line("queue entry", std::to_string(run.queue_entry_id()));
  line("created", clock_text(run.create_time()) + " UTC");
  if (run.has_start_time()) line("started", clock_text(run.start_time()) + " UTC");
  if (run.has_end_time())
    line("ended", clock_text(run.end_time()) + " UTC" +
                      (run.has_elapsed_duration()
                           ? ", after " + span_text(seconds_of(run.elapsed_duration()))
                           : ""));
  if (run.restart_count() > 0) line("restarts", std::to_string(run.restart_count()));
  line("largest lag", span_text(seconds_of(run.max_lag_duration())) + " of cell time");
  line("cell file",
       run.config_hash().empty() ? "none: its rows are a file's, imported" : run.config_hash());
  for (int i = 1; i < run.configurations_size(); ++i)
    line("", "from " + clock_text(run.configurations(i).from_time()) +
                 " UTC on: " + run.configurations(i).hash());
  for (const auto& mark : run.corrections())
    for (const auto& text : mark_texts(mark)) line(text.starts_with(" ") ? "" : "rests on", text);
}

void print_ahead(const Console& console, const v1::RunProgress& progress) {
  if (!progress.has_remaining_band()) return;
  const Paint paint = console.paint_out();
  console.out << paint.dim("ahead         ") << span_text(seconds_of(progress.remaining_duration()))
              << " of cell time (" << band_text(progress.remaining_band()) << ")\n";
  const auto state = progress.run().state();
  if (state == v1::Run::STATE_PAUSED) return;  // nobody knows when a person resumes it
  console.out << paint.dim("ends          ")
              << end_text(progress.estimated_end_time(), progress.earliest_end_time(),
                          progress.latest_end_time(), progress.remaining_band().share())
              << " cell time\n";
}

}  // namespace driftwise::cli
