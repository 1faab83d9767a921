#include "server/application/queue/run_report.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>

#include "server/core/reasons.h"

namespace driftwise::application {

std::string run_report(const QueueEntry& entry, const RunRecord& run,
                       const std::vector<ClosureRecord>& closures,
                       const std::function<UtcTime(CellTime)>& utc) {
  std::string text;
  const auto line = [&text](const char* name, const std::string& value) {
    text += fmt::format("{:<14}{}\n", name, value);
  };
  const auto time = [&utc](CellTime instant) { return to_iso8601(utc(instant)); };
  line("run", fmt::format("{} '{}'", run.id.value, run.name));
  line("queue entry", fmt::format("{} '{}'", entry.id.value, entry.name));
  line("state", std::string(to_string(run.state)));
  line("trajectory", fmt::format("{}, {} rows", run.trajectory_name, run.rows));
  line("points", fmt::format("{} accepted, {} given up, {} attempts", run.accepted, run.given_up,
                             run.attempts));
  line("started", time(run.started));
  line("ended", time(run.ended));
  line("operator", run.operator_name);
  line("restarts", fmt::format("{}", run.restarts));
  line("largest lag", fmt::format("{:.2f} s of cell time", run.max_lag_s));
  line("zeros", fmt::format("{} returns to zero", closures.size()));
  for (const auto& closure : closures)
    if (closure.decision != ClosureDecision::within)
      line("zero", fmt::format("{} line {}: {}", time(closure.measured.utc), closure.line,
                               closure.sentence));
  line("cell file", run.config_hash);
  for (const auto& item : run.metadata) line("metadata", item.key + "=" + item.value);
  if (!entry.condition.empty()) line("waited for", entry.condition);
  for (const auto& result : entry.results) line(result.good ? "result" : "failed", result.text);
  return text;
}

std::string report_path(const std::string& database, QueueEntryId entry, RunId run) {
  const auto folder = std::filesystem::path(database).parent_path() / "reports";
  return (folder / fmt::format("queue-{}-run-{}.txt", entry.value, run.value)).string();
}

Result<void> write_report(const std::string& path, const std::string& text) {
  namespace fs = std::filesystem;
  std::error_code failed;
  fs::create_directories(fs::path(path).parent_path(), failed);
  const auto part = path + ".part";
  if (!failed) {
    std::ofstream file(part, std::ios::binary | std::ios::trunc);
    file << text;
    file.close();
    if (file)
      fs::rename(part, path, failed);
    else
      failed = std::make_error_code(std::errc::io_error);
  }
  if (!failed) return {};
  std::error_code ignored;
  fs::remove(part, ignored);
  return fail(ErrorCode::internal, reasons::kCannotWrite,
              fmt::format("the report {} cannot be written: {}: look at the folder's rights and "
                          "its room",
                          path, failed.message()));
}

}  // namespace driftwise::application
