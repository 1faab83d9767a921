#include "server/diagnosis/report/instrument_numbers.h"

#include <algorithm>
#include <cmath>

#include "server/core/units.h"
#include "server/diagnosis/catalogue/linear_parameter.h"
#include "server/diagnosis/rows/weighted_fit.h"

namespace driftwise::diagnosis {
namespace {

// Outputs that follow the coordinates instead of measuring them: motors, and what motors say of
// coordinates (a coordinate frame).
bool outputs_follow(const Problem& problem) {
  return !problem.given_outputs.empty() ||
         std::ranges::all_of(problem.outputs, [](const ProblemOutput& output) {
           return is_motor_symbol(output.channel.symbol);
         });
}

}  // namespace

std::optional<Eigen::VectorXd> slopes_along(const Problem& problem, const std::string& symbol) {
  std::size_t at = problem.base.size();
  for (std::size_t k = 0; k < problem.base.size(); ++k) {
    const auto& factors = problem.base[k].factors;
    if (factors.size() != 1) continue;
    const auto* power = std::get_if<effects::Power>(&factors.front());
    if (power != nullptr && power->symbol == symbol && power->exponent == 1) at = k;
  }
  if (at == problem.base.size()) return std::nullopt;
  Eigen::VectorXd slopes(static_cast<Eigen::Index>(problem.outputs.size()));
  for (std::size_t o = 0; o < problem.outputs.size(); ++o) {
    const WeightedFit fit(problem, problem.learned(problem.base_columns), Eigen::MatrixXd(), o);
    slopes[static_cast<Eigen::Index>(o)] = fit.coefficient(static_cast<Eigen::Index>(at));
  }
  return slopes;
}

std::string number_name(std::size_t value, const std::string& name, const effects::Term& term,
                        std::size_t terms) {
  std::string text = name;
  if (value > 0) text = "further" + (value > 1 ? std::to_string(value) : "") + "_" + name;
  // The only thing that a term of several is named after: "ppm_per_k" of x:t05 beside that of
  // y:t05.
  if (terms < 2) return text;
  if (const auto* power = std::get_if<effects::Power>(&term.factors.front()))
    text += "_" + power->symbol;
  return text;
}

std::optional<std::vector<FoundParameter>> instrument_numbers(
    const Problem& problem, const Cause& cause, const Named& named, const std::string& axis,
    const Eigen::MatrixXd& coefficients, const Eigen::MatrixXd& errors) {
  const auto* column = problem.data().find(axis);
  if (column == nullptr || !outputs_follow(problem)) return std::nullopt;
  const auto slopes = slopes_along(problem, axis);
  if (!slopes) return std::nullopt;
  const auto unit = summary_unit(column->channel.unit);
  const std::size_t of_one_value = named.values.front().terms.size();
  std::vector<FoundParameter> numbers;
  for (std::size_t k = 0; k < named.terms.size(); ++k) {
    const std::size_t v = k / of_one_value;
    const double at = named.values[v].parameter;
    const auto number = unit.unit == "nm" ? linear_number(cause.linear, named.terms[k], at)
                        : unit.unit == "arcsec"
                            ? linear_number_of_angle(cause.linear, named.terms[k], at)
                            : LinearNumber{};
    double own = 0, weight = 0;
    for (Eigen::Index o = 0; o < slopes->size(); ++o) {
      const double error = errors(static_cast<Eigen::Index>(k), o);
      if (!(error > 0) || !std::isfinite(error)) continue;
      own -= (*slopes)[o] * coefficients(static_cast<Eigen::Index>(k), o) / (error * error);
      weight += std::pow((*slopes)[o] / error, 2);
    }
    if (number.name.empty() || !(weight > 0)) continue;
    const double factor = unit.factor * number.factor, value = factor * own / weight,
                 reach = kSigmaToU90 * std::abs(factor) / std::sqrt(weight);
    numbers.push_back({number_name(v, number.name, named.terms[k], of_one_value),
                       value,
                       Interval{value - reach, value + reach},
                       {}});
  }
  return numbers;
}

}  // namespace driftwise::diagnosis
