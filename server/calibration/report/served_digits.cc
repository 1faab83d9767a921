#include "server/calibration/report/served_digits.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>

#include "server/core/reasons.h"
#include "server/effects/term_order.h"

namespace driftwise::calibration {
namespace {

using Eigen::Index;

constexpr double kMostLoss = 0.01;      // of the rms of the residuals
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
  if (served <= (1 + kMostLoss) * fitted + rounding) return {};
  const std::string unit = " " + output.channel.unit;
  return fail(ErrorCode::failed_precondition, reasons::kDigitsLost,
              output.channel.symbol + ": the fit leaves " + text_of(fitted) + unit +
                  " rms on its own rows, but the model as it is served, a sum of " +
                  std::to_string(output.terms.size()) + " terms in double precision, leaves " +
                  text_of(served) + unit + ": " + advice(design, output));
}

}  // namespace driftwise::calibration
