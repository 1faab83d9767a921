#include "server/diagnosis/report/as_read.h"

#include <algorithm>

#include "server/calibration/design/predict.h"
#include "server/core/units.h"
#include "server/diagnosis/report/sentence.h"
#include "server/diagnosis/rows/held_out_gain.h"
#include "server/effects/term_order.h"

namespace driftwise::diagnosis {
namespace {

constexpr double kAtMost = 0.8;  // of the rms error as read, at the interval's upper end

// The baseline's columns at the predicted pose, thermometers as read. No column: none reads one.
Eigen::MatrixXd columns_as_read(const Problem& problem, const Dataset& readings) {
  Dataset as_read = problem.prepared.conditions();
  for (auto& column : as_read.columns) {
    const auto* read = readings.find(column.channel.symbol);
    if (read != nullptr && is_structure_temperature(column.channel)) column.values = read->values;
  }
  Eigen::MatrixXd columns = problem.base_columns;
  bool any = false;
  for (std::size_t k = 0; k < problem.base.size(); ++k) {
    const auto symbols = effects::symbols_of(problem.base[k]);
    if (std::ranges::none_of(symbols, [&](const std::string& symbol) {
          const auto* column = as_read.find(symbol);
          return column != nullptr && is_structure_temperature(column->channel);
        }))
      continue;
    const auto made = calibration::raw_columns(as_read, {problem.base[k]});
    if (!made) continue;
    columns.col(static_cast<Eigen::Index>(k)) = made->col(0);
    any = true;
  }
  return any ? columns : Eigen::MatrixXd();
}

bool is_whole(const Problem& problem, const Eigen::MatrixXd& columns) {
  return rows_of(columns, problem.learn).allFinite() && rows_of(columns, problem.judge).allFinite();
}

}  // namespace

std::vector<std::string> worse_as_read(const Problem& problem, const Dataset& readings) {
  if (problem.judge.size() < kFewestJudges || readings.rows != problem.data().rows) return {};
  const Eigen::MatrixXd columns = columns_as_read(problem, readings);
  if (columns.size() == 0 || !is_whole(problem, columns)) return {};
  std::vector<std::string> sentences;
  for (const auto& output : problem.outputs) {
    const HeldOutRatio one =
        held_out_ratio(problem, output, SoftBase(columns), SoftBase(problem.base_columns));
    if (!(one.ratio_ci90.high < kAtMost)) continue;
    sentences.push_back(output.channel.symbol +
                        ": with the thermometers as they were read the baseline describes "
                        "rows held out to " +
                        size_text(kSigmaToU90 * one.before, output.unit) +
                        " (A90), with smoothed readings, as here, to " +
                        size_text(kSigmaToU90 * one.after, output.unit) +
                        ". Its thermal coefficients multiply the readings' noise: they are larger "
                        "than the readings "
                        "bear, and a slow effect without a name may hide in them. Fewer "
                        "thermometers, or a run from "
                        "another starting temperature, would show it");
  }
  return sentences;
}

}  // namespace driftwise::diagnosis
