#include "server/simulation/motor_slopes.h"

#include <algorithm>

#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/core/units.h"
#include "server/effects/term_evaluator.h"

namespace driftwise::simulation {
namespace {

double millimetres_per(const Channel& channel) {
  return mm_from_nm(summary_unit(channel.unit).factor);
}

// One reading from rest; "datum" is no channel of the table, so further datums count 0.
Result<double> output_at(const calibration::OutputModel& output,
                         const std::vector<std::string>& symbols,
                         const std::vector<double>& values) {
  DRIFTWISE_TRY(auto evaluator, effects::TermEvaluator::create(output.terms, symbols));
  Eigen::VectorXd columns(static_cast<Eigen::Index>(output.terms.size()));
  evaluator.step(0, values, {columns.data(), output.terms.size()});
  return columns.dot(output.coefficients) * millimetres_per(output.channel);
}

}  // namespace

Result<Eigen::MatrixXd> motor_slopes(const calibration::Model& model,
                                     const std::vector<std::string>& axes) {
  std::vector<std::string> symbols;
  std::vector<double> middle;
  for (const auto& range : model.domain) {
    symbols.push_back(range.channel.symbol);
    middle.push_back((range.min + range.max) / 2);
  }
  Eigen::MatrixXd slopes(static_cast<Eigen::Index>(model.outputs.size()),
                         static_cast<Eigen::Index>(axes.size()));
  for (std::size_t j = 0; j < axes.size(); ++j) {
    const auto at = std::ranges::find(symbols, axes[j]);
    if (at == symbols.end())
      return fail(ErrorCode::failed_precondition, reasons::kNoDomain,
                  "the simulation does not read " + axes[j] +
                      ": what is wrong with that length cannot be told from the motor side");
    const auto index = static_cast<std::size_t>(at - symbols.begin());
    const auto& range = model.domain[index];
    auto low = middle, high = middle;
    low[index] = range.min;
    high[index] = range.max;
    for (std::size_t o = 0; o < model.outputs.size(); ++o) {
      DRIFTWISE_TRY(const auto below, output_at(model.outputs[o], symbols, low));
      DRIFTWISE_TRY(const auto above, output_at(model.outputs[o], symbols, high));
      slopes(static_cast<Eigen::Index>(o), static_cast<Eigen::Index>(j)) =
          (above - below) / ((range.max - range.min) * millimetres_per(range.channel));
    }
  }
  return slopes;
}

}  // namespace driftwise::simulation
