// Checks of a formula before a fit, residuals of a model after it.

#include <algorithm>
#include <numeric>
#include <optional>

#include "server/application/datasets/amended_dataset.h"
#include "server/application/models/formula_check.h"
#include "server/application/models/model_integrity.h"
#include "server/application/models/models_service.h"
#include "server/application/models/run_to_check.h"
#include "server/application/plumbing/run_on.h"
#include "server/calibration/datum_zeros.h"
#include "server/calibration/design/predict.h"
#include "server/calibration/model/model_units.h"
#include "server/core/data/measured_by.h"
#include "server/core/data/stated_lines.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/core/units.h"
#include "server/diagnosis/check/check_memory.h"
#include "server/formats/csv/dataset_csv.h"
#include "server/formats/diagnosis/robot_names.h"
#include "server/formats/text/text.h"
#include "server/plans/robot_parts.h"

namespace driftwise::application {
namespace {

// Whether the model was fitted to this. One of before its data stated which instruments measured
// them knows the same rows by the hash of the text without that line.
bool fitted_to(const calibration::Lineage& lineage, const Dataset& data,
               const std::string& dataset_hash) {
  if (dataset_hash == lineage.dataset_hash) return true;
  if (!lineage.measured_by.empty()) return false;
  Dataset unstated = data;
  std::erase_if(unstated.metadata, [](const auto& line) {
    return line.first == kMeasuredByKey || line.first == kLeftOutKey;
  });
  return unstated.metadata.size() < data.metadata.size() &&
         formats::content_hash(formats::write_dataset_csv(unstated)) == lineage.dataset_hash;
}

using Columns = std::vector<std::vector<double>>;  // by output, one value per row, summary unit

// Of rows of the model's own datums, counted as the fit counted them.
Result<Columns> left_by(const calibration::Model& model, const Dataset& as_given) {
  Columns columns;
  DRIFTWISE_TRY(const Dataset data, calibration::in_model_units(model, as_given));
  const Dataset moved = calibration::in_first_datum(data, model.datum_zeros);
  for (const auto& output : model.outputs) {
    DRIFTWISE_TRY(const auto predicted, calibration::predict(moved, output));
    const auto* measured = data.find(output.channel.symbol);
    if (measured == nullptr)
      return fail(ErrorCode::invalid_argument, reasons::kUnknownChannel,
                  "the rows have no channel " + output.channel.name() + ", which the model gives");
    const double factor = summary_unit(output.channel.unit).factor;
    auto& column = columns.emplace_back(data.rows);
    for (std::size_t row = 0; row < data.rows; ++row)
      column[row] = (measured->values[row] - predicted[static_cast<Eigen::Index>(row)]) * factor;
  }
  return columns;
}

// Of a run that the model was not fitted to, from its own zero, as the check standard has it.
struct Carried {
  Columns columns;
  bool from_zero = true;  // false: a zero is not known, and the mean of its rows is taken out
};
Result<Carried> carried_to(const calibration::Model& model, diagnosis::RunToCheck run) {
  const auto robot = formats::robot_of_formula(model.formula);
  auto part = plans::part_of_robot(model, robot);
  const bool is_part = !robot.empty() && part;
  const formats::RobotNames names(run.data, is_part ? robot : std::string());
  if (is_part) {
    run.data = names.bare(std::move(run.data));
    for (auto& zero : run.zeros) zero = plans::part_of_robot(zero, robot);
  }
  const calibration::Model& bare = is_part ? *part : model;
  const auto plain = diagnosis::with_effects_as_channels(bare);
  auto read = diagnosis::as_the_model_reads(bare, std::move(run));
  if (!read) return tl::unexpected(is_part ? names.with_id(std::move(read.error())) : read.error());
  run = std::move(*read);
  Carried carried;
  for (const auto& output : plain.outputs) {
    auto errors = diagnosis::run_errors(output, model.lineage.rows_calibration, run);
    if (errors && errors->anchored && !run.data.excluded.empty()) {
      auto all = run;  // a row that is kept out of fits has a residual as well
      all.data.excluded.clear();
      errors = diagnosis::run_errors(output, model.lineage.rows_calibration, all);
    }
    if (!errors) {
      if (is_part) return tl::unexpected(names.with_id(std::move(errors.error())));
      return tl::unexpected(std::move(errors.error()));
    }
    carried.from_zero = carried.from_zero && errors->anchored;
    carried.columns.push_back(std::move(errors->values));
  }
  return carried;
}

// Everything that residuals are made of.
struct Rows {
  Dataset asked;
  std::vector<RunId> runs;                     // of asked; empty: rows of a text
  std::vector<correction::RowOrigin> origins;  // of asked
  std::optional<Dataset>
      own;  // all rows that the model was fitted to; none: asked has none, or all
  std::vector<diagnosis::RunToCheck> others;
};

// Rows of one run in a dataset of these runs, in order.
std::vector<std::size_t> rows_of_run(const Dataset& data, const std::vector<RunId>& runs,
                                     RunId run) {
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < data.rows; ++row)
    if (data.run.empty() ? runs.size() == 1 && runs.front() == run : data.run[row] == run.value)
      rows.push_back(row);
  return rows;
}

// from: rows of the same run, in the same order; read later, so that a run under way has more.
Result<void> put_rows(const Columns& columns, const std::vector<std::size_t>& from,
                      const std::vector<std::size_t>& to, RunId run, ModelResiduals& found) {
  if (from.size() < to.size())
    return fail(ErrorCode::internal, reasons::kRowsDiffer,
                "run " + std::to_string(run.value) + " had " + std::to_string(to.size()) +
                    " rows when it was read first and " + std::to_string(from.size()) +
                    " when it was read again: ask again");
  for (std::size_t o = 0; o < columns.size(); ++o)
    for (std::size_t i = 0; i < to.size(); ++i)
      found.outputs[o].values[to[i]] = columns[o][from[i]];
  return {};
}

Result<void> fill_by_run(const calibration::Model& model, const Rows& rows, ModelResiduals& found) {
  if (rows.own) {
    DRIFTWISE_TRY(const auto columns, left_by(model, *rows.own));
    for (const RunId run : model.lineage.runs)
      DRIFTWISE_RETURN_IF_ERROR(put_rows(columns, rows_of_run(*rows.own, model.lineage.runs, run),
                                         rows_of_run(rows.asked, rows.runs, run), run, found));
  }
  for (const auto& other : rows.others) {
    DRIFTWISE_TRY(const auto carried, carried_to(model, other));
    if (!carried.from_zero) found.mean_taken_out.push_back(other.run);
    std::vector<std::size_t> all(other.data.rows);
    std::iota(all.begin(), all.end(), std::size_t{0});
    DRIFTWISE_RETURN_IF_ERROR(put_rows(
        carried.columns, all, rows_of_run(rows.asked, rows.runs, other.run), other.run, found));
  }
  return {};
}

Result<ModelResiduals> residuals_of(const calibration::Model& model, Rows rows) {
  ModelResiduals found;
  found.dataset_hash = formats::content_hash(formats::write_dataset_csv(rows.asked));
  found.same_rows = fitted_to(model.lineage, rows.asked, found.dataset_hash);
  for (const auto& output : model.outputs)
    found.outputs.push_back({output.channel, std::vector<double>(rows.asked.rows, kMissing), {}});
  if (found.same_rows || (!rows.own && rows.others.empty())) {
    DRIFTWISE_TRY(auto columns, left_by(model, rows.asked));
    for (std::size_t o = 0; o < columns.size(); ++o)
      found.outputs[o].values = std::move(columns[o]);
  } else {
    DRIFTWISE_RETURN_IF_ERROR(fill_by_run(model, rows, found));
  }
  for (std::size_t o = 0; o < model.outputs.size() && found.same_rows; ++o) {
    const auto& output = model.outputs[o];
    if (output.held_out.size() != rows.asked.rows) continue;
    found.outputs[o].held_out = output.held_out;
    for (double& error : found.outputs[o].held_out)
      error *= summary_unit(output.channel.unit).factor;
  }
  found.data = std::move(rows.asked);
  found.origins = std::move(rows.origins);
  return found;
}

Result<std::vector<diagnosis::RunToCheck>> others_of(Store& store, const std::vector<RunId>& runs,
                                                     const diagnosis::ModelMemory& memory) {
  std::vector<diagnosis::RunToCheck> others;
  for (const RunId id : runs) {
    DRIFTWISE_TRY(const auto run, store.runs().run(id));
    DRIFTWISE_TRY(auto other, run_to_check(store, run, memory));
    others.push_back(std::move(other));
  }
  return others;
}

}  // namespace

Awaitable<Result<FormulaCheck>> ModelsService::check_formula(FitRequest request) {
  DRIFTWISE_CO_TRY(auto dataset, co_await datasets_.load(request.runs, request.csv));
  co_return co_await run_on(worker_, check_formula_on, std::move(dataset), request);
}

Awaitable<Result<ModelResiduals>> ModelsService::residuals(ModelId id, std::vector<RunId> runs,
                                                           std::string csv) {
  DRIFTWISE_CO_TRY(const auto record, co_await get(id));
  DRIFTWISE_CO_TRY(auto read, read_formula_model(record, "residuals are shown"));
  if (runs.empty() && csv.empty()) runs = read.lineage.runs;
  if (runs.empty() && csv.empty())
    co_return fail(ErrorCode::failed_precondition, reasons::kNoRows,
                   "model " + std::to_string(id.value) +
                       " was fitted to a file, whose rows were not kept: hand in the file, or "
                       "import it as a run and fit that");
  DRIFTWISE_CO_TRY(auto sets, co_await datasets_.set_names(runs, csv));
  Rows rows;
  rows.runs = runs;
  if (csv.empty()) {
    DRIFTWISE_CO_TRY(auto asked, co_await reader_.call(amended_data, runs));
    rows.asked = std::move(asked.data);
    rows.origins = std::move(asked.origins);
  } else {
    DRIFTWISE_CO_TRY(rows.asked, co_await datasets_.load(runs, std::move(csv)));
  }
  const auto& fitted = read.lineage.runs;
  if (runs != fitted) {
    std::vector<RunId> others;
    for (const RunId run : runs)
      if (std::ranges::find(fitted, run) == fitted.end()) others.push_back(run);
    if (others.size() < runs.size()) {
      DRIFTWISE_CO_TRY(auto own, co_await datasets_.load(fitted, std::string()));
      rows.own = std::move(own);
    }
    const auto memory = diagnosis::memory_of(read);
    DRIFTWISE_CO_TRY(rows.others, co_await reader_.call(others_of, others, memory));
  }
  auto found = co_await run_on(
      worker_,
      [](const calibration::Model& model, Rows& all) {
        return residuals_of(model, std::move(all));
      },
      std::move(read), std::move(rows));
  if (found && sets.size() == found->data.rows) found->sets = std::move(sets);
  co_return found;
}

}  // namespace driftwise::application
