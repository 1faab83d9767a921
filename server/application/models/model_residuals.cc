// Checks of a formula before a fit, residuals of a model after it.

#include "server/application/models/formula_check.h"
#include "server/application/models/model_integrity.h"
#include "server/application/models/models_service.h"
#include "server/application/plumbing/run_on.h"
#include "server/calibration/datum_zeros.h"
#include "server/calibration/design/predict.h"
#include "server/core/data/measured_by.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/core/units.h"
#include "server/formats/csv/dataset_csv.h"
#include "server/formats/text/text.h"

namespace driftwise::application {
namespace {

// Whether the model was fitted to this. One of before its data stated which instruments measured
// them knows the same rows by the hash of the text without that line.
bool fitted_to(const calibration::Lineage& lineage, const Dataset& data,
               const std::string& dataset_hash) {
  if (dataset_hash == lineage.dataset_hash) return true;
  if (!lineage.measured_by.empty()) return false;
  Dataset unstated = data;
  std::erase_if(unstated.metadata, [](const auto& line) { return line.first == kMeasuredByKey; });
  return unstated.metadata.size() < data.metadata.size() &&
         formats::content_hash(formats::write_dataset_csv(unstated)) == lineage.dataset_hash;
}

Result<ModelResiduals> residuals_of(const calibration::Model& model, Dataset data) {
  ModelResiduals found;
  const Dataset moved = calibration::in_first_datum(data, model.datum_zeros);
  for (const auto& output : model.outputs) {
    DRIFTWISE_TRY(const auto predicted, calibration::predict(moved, output));
    const auto* measured = data.find(output.channel.symbol);
    if (measured == nullptr)
      return fail(ErrorCode::invalid_argument, reasons::kUnknownChannel,
                  "the rows have no channel " + output.channel.name() + ", which the model gives");
    const double factor = summary_unit(output.channel.unit).factor;
    auto& column = found.outputs.emplace_back(ModelResiduals::Output{output.channel, {}, {}});
    column.values.resize(data.rows);
    for (std::size_t row = 0; row < data.rows; ++row)
      column.values[row] =
          (measured->values[row] - predicted[static_cast<Eigen::Index>(row)]) * factor;
  }
  found.dataset_hash = formats::content_hash(formats::write_dataset_csv(data));
  found.same_rows = fitted_to(model.lineage, data, found.dataset_hash);
  for (std::size_t o = 0; o < model.outputs.size() && found.same_rows; ++o) {
    const auto& output = model.outputs[o];
    if (output.held_out.size() != data.rows) continue;
    found.outputs[o].held_out = output.held_out;
    for (double& error : found.outputs[o].held_out)
      error *= summary_unit(output.channel.unit).factor;
  }
  found.data = std::move(data);
  return found;
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
  DRIFTWISE_CO_TRY(auto dataset, co_await datasets_.load(std::move(runs), std::move(csv)));
  auto found = co_await run_on(
      worker_,
      [](const calibration::Model& fitted, Dataset& data) {
        return residuals_of(fitted, std::move(data));
      },
      std::move(read), std::move(dataset));
  if (found && sets.size() == found->data.rows) found->sets = std::move(sets);
  co_return found;
}

}  // namespace driftwise::application
