#include "clients/cli/commands/runs/report_command.h"

#include <memory>

#include "clients/cli/core/validators.h"
#include "driftwise/v1/record_service.grpc.pb.h"

namespace driftwise::cli {

ExitCode save_report(const Session& session, std::int64_t run, std::int64_t entry,
                     const std::string& file) {
  v1::GetReportRequest request;
  request.set_run_id(run);
  std::string page;
  session.connect().follow(&v1::RecordService::Stub::GetReport, request,
                           [&page](const v1::GetReportResponse& piece) {
                             page += piece.data();
                             return true;
                           });
  write_output_file(file, page);
  if (session.console.json) {
    nlohmann::ordered_json said{{"run_id", run}, {"file", file}, {"bytes", page.size()}};
    if (entry != 0) said["entry_id"] = entry;
    session.console.print_json(said);
  } else {
    session.console.out << file << ": run " << run << ", " << page.size() / 1024 << " KiB\n";
  }
  return ExitCode::done;
}

void add_report_command(CLI::App& app, Session& session) {
  struct Arguments {
    std::int64_t run = 0;
    std::string output;
  };
  auto& report = *app.add_subcommand("report", "Pages that open without a daemon");
  report.require_subcommand(1);
  auto a = std::make_shared<Arguments>();
  auto& run = add_command(report, session, "run", "One run as a self-contained HTML page",
                          [&session, a] { return save_report(session, a->run, 0, a->output); });
  run.add_option("id", a->run, "the run")->required()->check(positive_number());
  run.add_option("-o,--output", a->output, "the page to write")->required();
}

}  // namespace driftwise::cli
