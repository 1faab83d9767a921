#include "clients/cli/commands/runs/report_command.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>

#include "clients/cli/commands/runs/report_data.h"
#include "clients/cli/commands/runs/run_tables.h"
#include "clients/cli/core/text.h"
#include "driftwise/v1/cell_service.grpc.pb.h"
#include "driftwise/v1/commissioning_service.grpc.pb.h"
#include "driftwise/v1/record_service.grpc.pb.h"
#include "driftwise/v1/run_service.grpc.pb.h"

namespace driftwise::cli {
namespace {

namespace fs = std::filesystem;
using RunStub = v1::RunService::Stub;
using CellStub = v1::CellService::Stub;

struct ReportArguments {
  std::int64_t run = 0;
  std::string output, page_template;
};

// Where the daemon finds its page too: beside the installed program, or in the source it was built
// from.
std::string find_template() {
  std::error_code failed;
  const fs::path program = fs::read_symlink("/proc/self/exe", failed).parent_path();
  for (const char* place :
       {"../share/driftwise/web", "../clients/web/dist", "../../../clients/web/dist"})
    if (const fs::path page = program / place / "report.html"; fs::is_regular_file(page, failed))
      return page.lexically_normal().string();
  throw Failure{ExitCode::bad_input, "not_found", "NO_TEMPLATE",
                "found no report.html beside this program: build the web page (cmake --build BUILD "
                "--target web), or name the file with --template"};
}

std::vector<v1::Point> all_points(const Connection& connection, std::int64_t run) {
  constexpr int kPage = 1000;
  v1::ListPointsRequest request;
  request.set_run_id(run);
  request.set_limit(kPage);
  std::vector<v1::Point> points;
  while (true) {
    const auto page = connection.ask(&RunStub::ListPoints, request);
    points.insert(points.end(), page.points().begin(), page.points().end());
    if (page.points_size() < kPage) return points;
    request.set_after_point_id(points.back().id());
  }
}

std::vector<v1::Event> events_of(const Connection& connection, std::int64_t run) {
  constexpr int kPage = 1000;
  v1::ListEventsRequest request;
  request.set_limit(kPage);
  std::vector<v1::Event> events;
  while (true) {
    const auto page = connection.ask(&CellStub::ListEvents, request);
    for (const auto& event : page.events())
      if (event.has_run_id() && event.run_id() == run) events.push_back(event);
    if (page.events_size() < kPage) return events;
    request.set_after_event_id(page.events(page.events_size() - 1).id());
  }
}

// Enough points but returns to zero that have a wanted pose: then the run can be verified.
bool wanted_poses(const std::vector<v1::Point>& points) {
  int found = 0;
  for (const auto& point : points)
    found += !point.zero() && std::ranges::any_of(point.values(), [](const auto& value) {
      return value.channel().find("_target_") != std::string::npos && value.has_value();
    });
  return found >= 2;
}

std::string now_text() {
  google::protobuf::Timestamp now;
  now.set_seconds(std::chrono::duration_cast<std::chrono::seconds>(
                      std::chrono::system_clock::now().time_since_epoch())
                      .count());
  return iso_text(now);
}

ExitCode report_run(const Session& session, const ReportArguments& a) {
  const std::string page =
      read_input_file(a.page_template.empty() ? find_template() : a.page_template);
  const auto connection = session.connect();
  ReportSource source;
  v1::GetRunRequest request;
  request.set_run_id(a.run);
  source.run = connection.ask(&RunStub::GetRun, request);
  source.cell = connection.ask(&CellStub::GetStatus, {});
  source.points = all_points(connection, a.run);
  std::erase_if(source.points, [](const v1::Point& point) { return point.repeated_line(); });
  const auto closures = closures_of_run(connection, a.run);
  source.closures.assign(closures.closures().begin(), closures.closures().end());
  v1::ListAttemptsRequest attempts;
  attempts.set_run_id(a.run);
  const auto tries = connection.ask(&RunStub::ListAttempts, attempts);
  source.attempts.assign(tries.attempts().begin(), tries.attempts().end());
  source.events = events_of(connection, a.run);
  if (wanted_poses(source.points)) {
    v1::VerifyRunsRequest verify;
    verify.add_run_ids(a.run);
    source.verification = connection.ask(&RunStub::VerifyRuns, verify, 120);
  }
  source.head = connection.ask(&v1::RecordService::Stub::GetChainHead, {}).head();
  source.certificates = connection.ask(&v1::CommissioningService::Stub::ListCertificates, {});
  source.made = now_text();
  source.version = DRIFTWISE_VERSION;
  const std::string written = report_page(page, report_json(source));
  write_output_file(a.output, written);
  if (session.console.json)
    session.console.print_json({{"run_id", a.run},
                                {"file", a.output},
                                {"points", source.points.size()},
                                {"bytes", written.size()}});
  else
    session.console.out << a.output << ": run " << a.run << ", " << source.points.size()
                        << " points, " << written.size() / 1024 << " KiB\n";
  return ExitCode::done;
}

}  // namespace

void add_report_command(CLI::App& app, Session& session) {
  auto& report = *app.add_subcommand("report", "Pages that open without a daemon");
  report.require_subcommand(1);
  auto a = std::make_shared<ReportArguments>();
  auto& run = add_command(report, session, "run", "One run as a self-contained HTML page",
                          [&session, a] { return report_run(session, *a); });
  run.add_option("id", a->run, "the run")->required();
  run.add_option("-o,--output", a->output, "the page to write")->required();
  run.add_option("--template", a->page_template,
                 "report.html of the web page, where it is not beside the program");
}

}  // namespace driftwise::cli
