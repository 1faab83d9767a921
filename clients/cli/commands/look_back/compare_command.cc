#include <algorithm>
#include <memory>

#include "clients/cli/commands/look_back/look_back_commands.h"
#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "clients/cli/core/validators.h"
#include "driftwise/v1/look_back_service.grpc.pb.h"

namespace driftwise::cli {
namespace {

struct CompareArguments {
  std::vector<std::int64_t> runs;
  std::int64_t model = 0;
};

using SeriesOf =
    google::protobuf::RepeatedPtrField<v1::ComparedSeries> const& (v1::ComparedRun::*)() const;

// One row per quantity and unit that any of the runs has, two columns per run.
void print_block(const Console& console, const v1::CompareRunsResponse& response,
                 const std::string& title, SeriesOf series, const char* first, bool is_rate) {
  std::vector<std::pair<std::string, std::string>> names;  // with its unit
  for (const auto& run : response.runs())
    for (const auto& one : (run.*series)())
      if (const std::pair shown{one.name(), one.unit()};
          std::ranges::find(names, shown) == names.end())
        names.push_back(shown);
  if (names.empty()) return;
  std::vector<Table::Column> columns{{title}};
  for (const auto& run : response.runs()) {
    const std::string name = "run " + std::to_string(run.run_id());
    columns.push_back({name + " " + first, Align::right});
    columns.push_back({is_rate ? "per h" : "mean", Align::right});
  }
  Table table(columns);
  for (const auto& [name, unit] : names) {
    std::vector<Table::Cell> row{name + ", " + unit};
    const int digits = unit == "K" ? 3 : 1;
    for (const auto& run : response.runs()) {
      const v1::ComparedSeries* found = nullptr;
      for (const auto& one : (run.*series)())
        if (one.name() == name && one.unit() == unit) found = &one;
      row.push_back(found ? fixed(found->range(), digits) : "-");
      row.push_back(
          !found    ? "-"
          : is_rate ? (found->has_rate_per_h() ? signed_fixed(found->rate_per_h(), digits) : "-")
                    : signed_fixed(found->mean(), digits));
    }
    table.add(std::move(row));
  }
  console.out << '\n';
  table.print(console.out, console.paint_out());
}

ExitCode compare(const Session& session, const CompareArguments& a) {
  constexpr double kTakes_s = 120;
  v1::CompareRunsRequest request;
  for (const std::int64_t run : a.runs) request.add_run_ids(run);
  if (a.model != 0) request.set_model_id(a.model);
  const auto response =
      session.connect().ask(&v1::LookBackService::Stub::CompareRuns, request, kTakes_s);
  if (session.console.json) {
    session.console.print_json(json_from(response));
    return ExitCode::done;
  }
  for (const auto& run : response.runs()) {
    session.console.out << "run " << run.run_id() << "  " << run.name() << ", "
                        << clock_text(run.start_time()) << " UTC, " << run.point_count()
                        << " points";
    if (run.has_run_duration())
      session.console.out << " in " << span_text(seconds_of(run.run_duration()));
    session.console.out << '\n';
    if (!run.residual_trouble().empty())
      session.console.out << "  no residuals: " << run.residual_trouble() << '\n';
  }
  print_block(session.console, response, "returns to zero", &v1::ComparedRun::zero, "range", true);
  print_block(session.console, response, "temperatures", &v1::ComparedRun::temperatures, "range",
              true);
  print_block(session.console, response, "residuals", &v1::ComparedRun::residuals, "range", false);
  return ExitCode::done;
}

}  // namespace

void add_compare_command(CLI::App& run, Session& session) {
  auto a = std::make_shared<CompareArguments>();
  CLI::App& command = add_command(run, session, "compare",
                                  "Runs side by side: returns to zero, temperatures, residuals",
                                  [&session, a] { return compare(session, *a); });
  command.add_option("RUN", a->runs, "up to 8 runs")->required()->check(positive_number());
  command.add_option("--model", a->model, "whose residuals")->check(positive_number());
}

}  // namespace driftwise::cli
