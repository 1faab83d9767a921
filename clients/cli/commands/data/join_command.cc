#include "clients/cli/commands/data/join_command.h"

#include <algorithm>
#include <charconv>
#include <memory>
#include <optional>

#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/validators.h"
#include "clients/cli/core/value_or_throw.h"
#include "clients/cli/pages/join_page.h"
#include "clients/cli/pages/run_text.h"
#include "driftwise/v1/data_service.grpc.pb.h"
#include "server/core/data/row_marks.h"
#include "server/correction/described_stage.h"
#include "server/formats/cell_file/cell_file_correction.h"
#include "server/formats/csv/dataset_csv.h"
#include "server/formats/csv/set_names.h"
#include "server/formats/join/join_report.h"

namespace driftwise::cli {
namespace {

struct JoinArguments {
  std::vector<std::string> inputs;
  std::string name, output, correction, request_id;
  double max_temperature_difference_k = 0.5, max_zero_difference_um = 2;
  bool subtract_returns = false, dry_run = false;
};

std::optional<std::int64_t> run_number(const std::string& text) {
  std::int64_t number = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (code != std::errc{} || end != text.data() + text.size() || number <= 0) return std::nullopt;
  return number;
}

ExitCode join_runs(const Session& session, const JoinArguments& a) {
  if (!a.output.empty())
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  "-o writes the join of files; the join of runs becomes a run: join first, then "
                  "driftwise data export RUN -o " +
                      a.output};
  if (!a.correction.empty())
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  "--correction is for files: runs are corrected as their cell file says"};
  v1::JoinRunsRequest request;
  for (const auto& input : a.inputs) request.add_run_ids(*run_number(input));
  request.set_name(a.name);
  request.set_subtract_returns(a.subtract_returns);
  request.set_max_temperature_difference_k(a.max_temperature_difference_k);
  request.set_max_zero_difference_um(a.max_zero_difference_um);
  request.set_dry_run(a.dry_run);
  request.set_request_id(a.request_id);
  const auto joined = session.connect().ask(&v1::DataService::Stub::JoinRuns, request, 120);
  const auto report = nlohmann::ordered_json::parse(joined.report_json());
  auto& console = session.console;
  if (console.json) {
    nlohmann::ordered_json json{{"report", report}};
    if (joined.has_run()) json["run"] = json_from(joined.run());
    console.print_json(json);
    return ExitCode::done;
  }
  print_join(console.out, console.paint_out(), report);
  if (joined.has_run()) {
    console.out << '\n';
    print_run(console, joined.run());
  }
  return ExitCode::done;
}

ExitCode join_files(const Session& session, const JoinArguments& a) {
  auto& console = session.console;
  if (a.output.empty() && !a.dry_run)
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  "the join of files is a file: give -o FILE, or --dry-run for its report alone"};
  correction::JoinParts parts;
  std::vector<std::string> set_names;  // of the first part, whose sets the join has
  for (const auto& file : a.inputs) {
    const std::string text = read_input_file(file);
    if (parts.empty()) set_names = value_or_throw(formats::read_set_names(text, file));
    auto part = value_or_throw(formats::read_join_part(text, file));
    const auto rows = leave_passages_out(part.data);  // they are none of the plan
    if (parts.empty() && !set_names.empty()) {
      std::vector<std::string> names;
      for (const auto row : rows) names.push_back(std::move(set_names[row]));
      set_names = std::move(names);
    }
    parts.push_back(std::move(part));
  }
  if (!a.correction.empty()) {
    const auto described =
        value_or_throw(formats::parse_correction_file(read_input_file(a.correction), a.correction));
    for (auto& part : parts)
      part.stage = correction::stage_from(described, correction::measured_robot(part.data));
  }
  correction::JoinRules rules;
  rules.subtract_returns = a.subtract_returns;
  rules.max_temperature_difference_k = a.max_temperature_difference_k;
  rules.max_zero_difference_mm = 1e-3 * a.max_zero_difference_um;
  auto joined = value_or_throw(correction::join(parts, rules));
  joined.data.metadata = formats::join_metadata(parts, rules, joined.report);
  auto report = formats::join_json(parts, rules, joined.report);
  if (!a.dry_run) {
    std::vector<std::string> names;
    if (!set_names.empty())
      for (const auto row : joined.rows) names.push_back(set_names[static_cast<std::size_t>(row)]);
    const std::string csv = formats::with_set_names(formats::write_dataset_csv(joined.data), names);
    if (a.output == "-") {
      console.out << csv << std::flush;
      return ExitCode::done;
    }
    write_output_file(a.output, csv, a.inputs);
  }
  if (console.json) {
    nlohmann::ordered_json json{{"report", std::move(report)}};
    if (!a.dry_run) json["file"] = a.output;
    console.print_json(json);
    return ExitCode::done;
  }
  print_join(console.out, console.paint_out(), report);
  if (!a.dry_run) console.err << "wrote " << a.output << '\n';
  return ExitCode::done;
}

ExitCode join_inputs(const Session& session, const JoinArguments& a) {
  const auto is_run = [](const std::string& text) { return run_number(text).has_value(); };
  if (std::ranges::all_of(a.inputs, is_run)) return join_runs(session, a);
  const auto run = std::ranges::find_if(a.inputs, is_run);
  if (run != a.inputs.end())
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  "found run " + *run +
                      " beside a file, expected runs or files: import the file first "
                      "(driftwise data import), or write ./" +
                      *run + " for a file of that name"};
  return join_files(session, a);
}

}  // namespace

void add_join_command(CLI::App& data, Session& session) {
  auto a = std::make_shared<JoinArguments>();
  CLI::App& join = add_command(
      data, session, "join",
      "Runs of one trajectory, measured in different set-ups, as one dataset (docs/joined-runs.md)",
      [&session, a] { return join_inputs(session, *a); });
  join.add_option("INPUT", a->inputs,
                  "numbers of runs: the join becomes a run; or dataset CSV files: no daemon needed")
      ->required();
  join.add_option("--name", a->name, "of the joined run; else \"join of runs 3, 4, 5\"");
  join.add_option("-o,--output", a->output, "of files: write this file, - for standard output");
  join.add_option("--correction", a->correction,
                  "of files: cell.toml, or a file with its [correction] section alone");
  join.add_flag("--subtract-returns", a->subtract_returns,
                "subtract the line between the returns to zero before and after each pose");
  join.add_option("--max-temperature-difference", a->max_temperature_difference_k,
                  "of a thermometer between the datums of two runs, K")
      ->check(positive_number());
  join.add_option("--max-zero-difference", a->max_zero_difference_um,
                  "of a motor coordinate at pose zero, um; of files: in each row")
      ->check(positive_number());
  join.add_flag("--dry-run", a->dry_run, "report, store nothing");
  join.add_option("--request-id", a->request_id,
                  "the same id again answers with the run of the first time");
}

}  // namespace driftwise::cli
