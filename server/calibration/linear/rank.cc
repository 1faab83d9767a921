#include "server/calibration/linear/rank.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "server/effects/term_order.h"

namespace driftwise::calibration {
namespace {

constexpr double kMeasurableTemperature_k = 0.5e-3;

std::string short_number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g", value);
  return text.data();
}

// A design knows names, not units: tNN is a thermometer's by habit.
bool is_temperature(const std::string& name) {
  return name.size() >= 2 && name.front() == 't' &&
         std::ranges::all_of(name.substr(1), [](char c) { return c >= '0' && c <= '9'; });
}

}  // namespace

std::string constant_sentence(const Design& design, int term) {
  const auto& expansion = design.basis.expansions[static_cast<std::size_t>(term)];
  const auto& monomial = design.basis.monomials[static_cast<std::size_t>(expansion.top)];
  if (monomial.size() != 1) return {};
  const auto& variable = design.variables[static_cast<std::size_t>(monomial.front().first)];
  const double range = variable.max - variable.min;
  if (range <= 0) return variable.name + " is constant at " + effects::number_text(variable.min);
  const bool temperature = is_temperature(variable.name);
  if (temperature && range < kMeasurableTemperature_k)
    return variable.name + " is constant within " + short_number(range * 1e3) + " mK";
  if (range < 1e-7 * std::abs(variable.max))
    return variable.name + " is constant within " + short_number(range) + " of " +
           short_number(variable.max);
  return {};
}

std::string collinear_sentence(const Design& design, const OrthogonalSet& set, int term) {
  const auto name = [&design](int index) {
    return effects::notation(design.terms[static_cast<std::size_t>(index)]);
  };
  const Eigen::VectorXd weights = set.reproduced_by_set(term);
  std::string others;
  bool constant = false;
  int count = 0;
  for (Eigen::Index i = 0; i < weights.size(); ++i) {
    const int column = set.order()[static_cast<std::size_t>(i)];
    if (std::abs(weights[i]) * set.norm(column) < 1e-6 * set.norm(term)) continue;
    if (design.terms[static_cast<std::size_t>(column)].is_constant()) {
      constant = true;
      continue;
    }
    others += (others.empty() ? "" : ", ") + name(column);
    ++count;
  }
  if (others.empty()) {
    const std::string sentence = constant_sentence(design, term);
    if (!sentence.empty()) return sentence;
    return name(term) + (constant ? " is constant on these rows" : " is zero on these rows");
  }
  if (count == 1 && !constant)
    return others + " and " + name(term) + " cannot be told apart on these rows";
  return name(term) + " cannot be told apart from " + others + " on these rows";
}

}  // namespace driftwise::calibration
