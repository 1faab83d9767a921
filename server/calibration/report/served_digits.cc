#include "server/calibration/report/served_digits.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>

#include "server/core/reasons.h"
#include "server/effects/term_evaluator.h"
#include "server/effects/term_order.h"

namespace driftwise::calibration {
namespace {

using Eigen::Index;

constexpr double kMostLoss = 0.01;      // of the rms of the residuals, and of a variance
constexpr double kRounding = 1e-9;      // of the output's half range: no instrument shows it
constexpr double kRoundingOfValue = 8;  // ulps of the output itself, as it stands in the data

// What the terms in can be told to the reader by: the variable that lies furthest from zero, in its
// own half ranges, among those they read.
const Variable* furthest_from_zero(const Design& design, const OutputModel& output) {
  const Variable* furthest = nullptr;
  double most = 0;
  for (const auto& variable : design.variables) {
    const bool read = std::ranges::any_of(output.terms, [&](const effects::Term& term) {
      const auto symbols = effects::symbols_of(term);
      return std::ranges::find(symbols, variable.name) != symbols.end();
    });
    const double half = (variable.max - variable.min) / 2;
    if (!read || !(half > 0)) continue;
    const double away = std::abs(variable.max + variable.min) / 2 / half;
    if (away <= most) continue;
    most = away;
    furthest = &variable;
  }
  return furthest;
}

constexpr std::size_t kLeverageRows = 512;  // enough: rounding errors of a root are the same at all

// Root mean square over rows from all over of what the served root's sums differ from the
// orthonormal columns by, beside those columns'.
double lost_share(const Design& design, const Solution& solution) {
  const auto k = solution.root.rows();
  const auto rows = static_cast<std::size_t>(design.row_count());
  if (k == 0 || rows == 0) return 0;
  const std::size_t count = std::min(rows, kLeverageRows);
  const Index m = design.monomials();
  const Eigen::MatrixXd weights = solution.shape * solution.to_orthonormal;
  const Eigen::RowVectorXd means = design.columns.means().head(m).transpose() * weights;
  double lost = 0, whole = 0;
  Eigen::VectorXd raw(k);
  for (std::size_t i = 0; i < count; ++i) {
    const auto at = count == 1 ? 0 : (rows - 1) * i / (count - 1);
    const Eigen::RowVectorXd block = design.block(static_cast<Index>(at), 1);
    if (!(block[0] > 0)) continue;
    const Eigen::RowVectorXd orthonormal = block.head(m) * weights / block[0] + means;
    for (Index j = 0; j < k; ++j) {
      const auto column = static_cast<std::size_t>(solution.columns[static_cast<std::size_t>(j)]);
      const auto top = static_cast<std::size_t>(design.basis.expansions[column].top);
      raw[j] = 1;
      for (const auto& [variable, exponent] : design.basis.monomials[top])
        raw[j] *= effects::power(
            design.columns.values(static_cast<std::size_t>(variable))[design.rows[at]], exponent);
    }
    lost += (raw.transpose() * solution.root - orthonormal).squaredNorm();
    whole += orthonormal.squaredNorm();
  }
  return whole > 0 ? std::sqrt(lost / whole) : 0;
}

std::string text_of(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

std::string advice(const Design& design, const OutputModel& output) {
  const Variable* variable = furthest_from_zero(design, output);
  if (variable == nullptr) return "offer fewer terms";
  const double middle = (variable->max + variable->min) / 2,
               half = (variable->max - variable->min) / 2;
  return variable->name + " lies at " + text_of(middle) + " +- " + text_of(half) +
         ", where its powers are alike to rounding: take an offset of about " + text_of(middle) +
         " off that channel, or offer lower powers of it";
}

}  // namespace

Result<void> check_served_digits(const Design& design, const Solution& solution,
                                 const Eigen::VectorXd& residuals, const OutputModel& output) {
  if (residuals.size() == 0) return {};
  const auto measured = std::ranges::find(design.outputs, output.channel.symbol, &Channel::symbol) -
                        design.outputs.begin();
  const auto values = design.columns.output(static_cast<std::size_t>(measured));
  double squares = 0, weights = 0, low = HUGE_VAL, high = -HUGE_VAL;
  for (Index i = 0; i < residuals.size(); ++i) {
    const std::size_t row = design.rows[static_cast<std::size_t>(i)];
    squares += design.columns.weight(row) * residuals[i] * residuals[i];
    weights += design.columns.weight(row);
    low = std::min(low, values[row]);
    high = std::max(high, values[row]);
  }
  const double served = std::sqrt(squares / weights);
  const double fitted = std::sqrt(solution.rss / weights);
  const double rounding =
      kRounding * (high - low) / 2 + kRoundingOfValue * std::numeric_limits<double>::epsilon() *
                                         std::max(std::abs(low), std::abs(high));
  if (served <= (1 + kMostLoss) * fitted + rounding) {
    const double lost = lost_share(design, solution);
    if (lost <= kMostLoss / 2) return {};
    return fail(ErrorCode::failed_precondition, reasons::kDigitsLost,
                output.channel.symbol + ": its uncertainty as it is served, from sums of " +
                    std::to_string(output.terms.size()) + " terms in double precision, is off by " +
                    text_of(100 * lost) + " % on the fit's own rows: " + advice(design, output));
  }
  const std::string unit = " " + output.channel.unit;
  return fail(ErrorCode::failed_precondition, reasons::kDigitsLost,
              output.channel.symbol + ": the fit leaves " + text_of(fitted) + unit +
                  " rms on its own rows, but the model as it is served, a sum of " +
                  std::to_string(output.terms.size()) + " terms in double precision, leaves " +
                  text_of(served) + unit + ": " + advice(design, output));
}

}  // namespace driftwise::calibration
