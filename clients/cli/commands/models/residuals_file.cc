#include "clients/cli/commands/models/residuals_file.h"

#include "clients/cli/core/console.h"
#include "server/calibration/datum_zeros.h"
#include "server/calibration/design/predict.h"
#include "server/formats/csv/dataset_csv.h"

namespace driftwise::cli {

std::string residuals_csv(const Dataset& data, const calibration::Model& model) {
  const Dataset moved = calibration::in_first_datum(data, model.datum_zeros);
  Dataset table;
  table.metadata = {{"residuals of", model.formula}};
  table.rows = data.rows;
  table.time_s = data.time_s;
  table.set = data.set;
  table.line = data.line;
  table.zero = data.zero;
  table.run = data.run;
  table.datum = data.datum;
  table.excluded = data.excluded;
  for (const auto& output : model.outputs) {
    const auto predicted = calibration::predict(moved, output);
    if (!predicted)
      throw Failure{ExitCode::bad_input, std::string(to_string(predicted.error().code)),
                    predicted.error().reason, predicted.error().message};
    const auto& [symbol, unit] = output.channel;
    const SummaryUnit summary = summary_unit(unit);
    const auto& measured = data.find(symbol)->values;
    std::vector<double> values(predicted->begin(), predicted->end()), residuals(data.rows);
    for (std::size_t row = 0; row < data.rows; ++row)
      residuals[row] = (measured[row] - values[row]) * summary.factor;
    table.columns.push_back({output.channel, measured});
    table.columns.push_back({{symbol + "_model", unit}, std::move(values)});
    table.columns.push_back({{symbol + "_residual", summary.unit}, std::move(residuals)});
    if (output.held_out.size() != data.rows) continue;
    std::vector<double> held_out = output.held_out;
    for (double& error : held_out) error *= summary.factor;
    table.columns.push_back({{symbol + "_held_out", summary.unit}, std::move(held_out)});
  }
  return formats::write_dataset_csv(table);
}

}  // namespace driftwise::cli
