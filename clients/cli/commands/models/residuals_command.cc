#include "clients/cli/commands/models/residuals_command.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "clients/cli/core/validators.h"
#include "driftwise/v1/model_service.grpc.pb.h"
#include "server/core/data/accuracy.h"
#include "server/core/data/row_marks.h"
#include "server/formats/csv/dataset_csv.h"
#include "server/formats/csv/set_names.h"

namespace driftwise::cli {
namespace {

struct ResidualsArguments {
  std::int64_t model = 0;
  std::vector<std::int64_t> runs;
  std::string file, output;
};

template <class To, class From>
std::vector<To> numbers_of(const From& values) {
  std::vector<To> out;
  out.reserve(static_cast<std::size_t>(values.size()));
  for (const auto value : values) out.push_back(static_cast<To>(value));
  return out;
}

std::size_t rows_of(const v1::ListResidualsResponse& residuals) {
  return residuals.outputs().empty() ? 0
                                     : static_cast<std::size_t>(residuals.outputs(0).values_size());
}

bool is_passage(const v1::ListResidualsResponse& residuals, int row) {
  return row < residuals.passage_size() && residuals.passage(row);
}

// As `data exclude` takes it; of several runs "14 of run 2". Of a file: its place there.
std::string row_name(const v1::ListResidualsResponse& residuals, int row) {
  if (row >= residuals.rows_size()) return std::to_string(row * residuals.row_step() + 1);
  const auto& runs = residuals.row_runs();
  const bool several =
      std::ranges::any_of(runs, [&](std::int64_t run) { return run != runs.Get(0); });
  return std::to_string(residuals.rows(row)) +
         (several ? " of run " + std::to_string(runs.Get(row)) : "");
}

// Columns as `fit --residuals` names them: q1_residual_nm, q1_held_out_nm.
Dataset table_of(const v1::ListResidualsResponse& residuals, std::int64_t model) {
  Dataset table;
  table.metadata = {{"residuals of", "model " + std::to_string(model)}};
  table.rows = rows_of(residuals);
  table.time_s = numbers_of<double>(residuals.time_s());
  table.line = numbers_of<std::int64_t>(residuals.line());
  for (const bool validation : residuals.validation())
    table.set.push_back(validation ? PointSet::validation : PointSet::calibration);
  for (const bool zero : residuals.zero()) table.zero.push_back(zero ? 1 : 0);
  for (int row = 0; row < residuals.excluded_size(); ++row)
    table.excluded.push_back(!residuals.excluded(row)     ? kInUse
                             : is_passage(residuals, row) ? kPassageRow
                                                          : kExcludedRow);
  for (const auto& column : residuals.variables())
    table.columns.push_back(
        {{column.symbol(), column.unit()}, numbers_of<double>(column.values())});
  for (const auto& output : residuals.outputs()) {
    table.columns.push_back(
        {{output.output() + "_residual", output.unit()}, numbers_of<double>(output.values())});
    if (output.held_out_size() == output.values_size())
      table.columns.push_back(
          {{output.output() + "_held_out", output.unit()}, numbers_of<double>(output.held_out())});
  }
  return table;
}

using ResidualOutput = v1::ListResidualsResponse::Output;

// One line of the summary: figures over the rows of one set, and where the largest error is. named:
// of the validation set of this name alone; empty: of all.
void add_summary(Table& table, const v1::ListResidualsResponse& residuals,
                 const ResidualOutput& output,
                 const google::protobuf::RepeatedField<double>& values, bool validation,
                 const std::string& rows, const std::string& named = {}) {
  std::vector<double> errors;
  int largest = -1;
  for (int row = 0; row < values.size(); ++row) {
    const bool out = row < residuals.excluded_size() && residuals.excluded(row);
    if (out || residuals.validation(row) != validation || std::isnan(values[row])) continue;
    if (!named.empty() && residuals.sets(row) != named) continue;
    errors.push_back(values[row]);
    if (largest < 0 || std::abs(values[row]) > std::abs(values[largest])) largest = row;
  }
  if (errors.size() < 2) return;
  const ErrorFigures figures = error_figures(errors);
  table.add({output.output() + " " + output.unit(), rows, std::to_string(figures.rows),
             fixed(figures.a90, 1), signed_fixed(figures.mean, 1), fixed(figures.u90, 1),
             signed_fixed(values[largest], 1), row_name(residuals, largest)});
}

// On standard error, with the rows on standard output: how much is left, and where most.
void print_summary(const Console& console, const v1::ListResidualsResponse& residuals) {
  Table table({{"output"},
               {"rows"},
               {"count", Align::right},
               {"A90", Align::right},
               {"mean", Align::right},
               {"S90", Align::right},
               {"largest", Align::right},
               {"in row", Align::right}});
  for (const auto& output : residuals.outputs()) {
    add_summary(table, residuals, output, output.values(), false, "calibration");
    add_summary(table, residuals, output, output.values(), true, "validation");
    for (const auto& set : output.named_sets())
      add_summary(table, residuals, output, output.values(), true, "  " + set.name(), set.name());
    add_summary(table, residuals, output, output.held_out(), false, "held-out blocks");
  }
  table.print(console.err, console.paint_err());
  if (residuals.row_step() > 1)
    console.err << "every " << residuals.row_step() << "th of " << residuals.row_count()
                << " rows\n";
  for (const std::int64_t run : residuals.runs_without_zero())
    console.err << "run " << run
                << ": its zero is not known, the mean of its errors is taken out\n";
  if (!residuals.same_rows())
    console.err << "not the very rows that the model was fitted to: rows were excluded or put back "
                   "since, or these are others. So no errors of held-out rows are shown: they are "
                   "kept for the rows of the fit\n";
  else if (std::ranges::all_of(residuals.outputs(),
                               [](const auto& output) { return output.held_out().empty(); }))
    console.err << "no errors of held-out rows: the fit held none out, had more than 20 000 rows, "
                   "or is of before they were kept\n";
}

ExitCode list_residuals(const Session& session, const ResidualsArguments& a) {
  if (!a.file.empty() && !a.runs.empty())
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  "of which rows? found both a file and --run; give one, or neither for those the "
                  "model was fitted to"};
  v1::ListResidualsRequest request;
  request.set_model_id(a.model);
  for (const std::int64_t run : a.runs) request.add_run_ids(run);
  if (!a.file.empty()) request.set_csv(read_input_file(a.file));
  const auto residuals = session.connect().ask(&v1::ModelService::Stub::ListResiduals, request, 60);
  if (session.console.json) {
    session.console.print_json(json_from(residuals));
    return ExitCode::done;
  }
  std::string csv = formats::write_dataset_csv(table_of(residuals, a.model));
  if (!residuals.sets().empty())
    csv = formats::with_set_names(csv, {residuals.sets().begin(), residuals.sets().end()});
  if (a.output.empty() || a.output == "-")
    session.console.out << csv << std::flush;
  else
    write_output_file(a.output, csv, {a.file});
  print_summary(session.console, residuals);
  return ExitCode::done;
}

}  // namespace

void add_residuals_command(CLI::App& model, Session& session) {
  auto a = std::make_shared<ResidualsArguments>();
  CLI::App& command =
      add_command(model, session, "residuals",
                  "What a model leaves unexplained, row by row, with the channels of those rows",
                  [&session, a] { return list_residuals(session, *a); });
  command.add_option("MODEL", a->model, "number of the model")
      ->required()
      ->check(positive_number());
  command.add_option("FILE", a->file, "dataset CSV, - for standard input; else ...");
  command.add_option("--run", a->runs, "... a run; repeatable. Neither: what it was fitted to")
      ->allow_extra_args(false)
      ->check(positive_number());
  command.add_option("-o,--output", a->output, "write this file instead of standard output");
}

}  // namespace driftwise::cli
