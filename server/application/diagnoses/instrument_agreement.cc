#include "server/application/diagnoses/instrument_agreement.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>

#include "server/core/reasons.h"
#include "server/core/units.h"
#include "server/effects/term_evaluator.h"
#include "server/effects/term_order.h"

namespace driftwise::application {
namespace {

constexpr double kShareOfDisagreement = 0.25;
constexpr double kNormal999 = 3.0902;  // 0.1 % point of the normal distribution

struct Physical {     // what a coefficient of an instrument's error means
  std::string unit;   // "arcsec"
  std::string what;   // "angle of the beam"
  double factor = 1;  // value = factor x nm per unit of the term
  double limit = std::numeric_limits<double>::infinity();
};

Physical physical_of(const effects::Term& term) {
  bool tilt = false, length = false, air = false;
  const effects::Call* call = nullptr;
  for (const auto& factor : term.factors) {
    if (const auto* one = std::get_if<effects::Call>(&factor)) {
      call = one;
      continue;
    }
    const auto& symbol = std::get<effects::Power>(factor).symbol;
    const bool is_pose = is_pose_symbol(symbol);
    tilt |= is_pose && symbol.front() == 'r';
    length |= is_pose && symbol.front() != 'r';
    air |= symbol == "air" || symbol == "pressure" || symbol == "humidity";
  }
  const std::string_view effect = call ? std::string_view(call->effect) : std::string_view();
  if (effect == "drift")
    return length ? Physical{"ppm/h", "drift of the scale", 1, 10}
                  : Physical{"nm/h", "drift of the zero", 1, 10'000};
  if (effect == "air_index")
    return length ? Physical{"", "share of the air's index", 1, 2}
                  : Physical{"mm", "dead path", 1, 5000};
  if ((effect == "sin" || effect == "cos") && !call->parameters.empty() &&
      call->parameters.front().unit == "nm")
    return {"nm", "amplitude", 1, call->parameters.front().value / 4};
  if (call != nullptr) return {"nm", "size"};
  if (tilt && length)
    return {"arcsec", "angle of the beam", 1 / (kRadPerArcsec * kRadPerArcsec * kNmPerMm), 3600};
  if (tilt) return {"mm", "lever arm", 1 / (kRadPerArcsec * kNmPerMm), 1000};
  if (air)
    return length ? Physical{"ppm", "change of the scale", 1, 2}
                  : Physical{"nm", "change of the zero", 1, 5000};
  return {"nm", "size"};
}

// Three significant digits, without an exponent where a person can read it.
std::string with_unit(double value, const std::string& unit) {
  const double size = std::abs(value);
  const double step =
      size >= 1000 && size < 1e9 ? std::pow(10, std::floor(std::log10(size)) - 2) : 0;
  const std::string digits = step > 0 ? fmt::format("{:.0f}", std::round(value / step) * step)
                                      : fmt::format("{:.3g}", value);
  return unit.empty() ? digits : digits + " " + unit;
}

std::string named(int number, const diagnosis::Finding& finding) {
  return fmt::format("finding {} ({}{}{})", number, finding.cause,
                     finding.subject.empty() ? "" : " ", finding.subject);
}

// The wave that a term is a part of: its sine and its cosine share one amplitude. Other terms are
// by themselves.
effects::Term whole_of(effects::Term term) {
  for (auto& factor : term.factors)
    if (auto* call = std::get_if<effects::Call>(&factor); call != nullptr && call->effect == "cos")
      call->effect = "sin";
  return term;
}

// Size of the term, in nm per unit of it: of a wave the amplitude that sine and cosine make
// together.
double size_nm(const diagnosis::Finding& finding, const InstrumentClaim& claim, Eigen::Index axis,
               std::size_t term) {
  const auto of = [&](std::size_t k) {
    return nm_from_mm(claim.error_mm(axis, static_cast<Eigen::Index>(k)));
  };
  const auto whole = whole_of(finding.terms[term]);
  double squares = 0;
  for (std::size_t k = 0; k < finding.terms.size(); ++k)
    if (whole_of(finding.terms[k]) == whole) squares += of(k) * of(k);
  return std::copysign(std::sqrt(squares), of(term));
}

Result<void> check_possible(int number, const diagnosis::Finding& finding,
                            const InstrumentClaim& claim) {
  for (std::size_t a = 0; a < claim.axes.size(); ++a)
    for (std::size_t k = 0; k < finding.terms.size(); ++k) {
      const auto physical = physical_of(finding.terms[k]);
      const double value =
          physical.factor * size_nm(finding, claim, static_cast<Eigen::Index>(a), k);
      if (std::abs(value) <= physical.limit) continue;
      return fail(
          ErrorCode::failed_precondition, reasons::kImpossibleParameter,
          fmt::format("{} would correct {} by {}, {} of {}: at most {} is possible. "
                      "The data cannot be explained by this instrument: look for another "
                      "cause, or accept other findings",
                      named(number, finding), claim.axes[a], effects::notation(finding.terms[k]),
                      physical.what, with_unit(value, physical.unit),
                      with_unit(physical.limit, physical.unit)));
    }
  return {};
}

// Of each term over the rows, about its mean: how much of the data one unit of it is.
std::optional<Eigen::VectorXd> sizes_of(const std::vector<effects::Term>& terms,
                                        const Dataset& data) {
  std::vector<std::string> symbols;
  for (const auto& term : terms)
    for (auto& symbol : effects::symbols_of(term))
      if (std::ranges::find(symbols, symbol) == symbols.end()) symbols.push_back(std::move(symbol));
  std::vector<std::span<const double>> values;
  for (const auto& symbol : symbols) {
    values.push_back(data.values_of(symbol));
    if (values.back().empty()) return std::nullopt;
  }
  auto evaluator = effects::TermEvaluator::create(terms, symbols);
  if (!evaluator || (evaluator->has_memory() && data.time_s.empty())) return std::nullopt;
  const Eigen::MatrixXd columns = evaluator->block(data.time_s, values, data.rows);
  Eigen::VectorXd sizes(columns.cols());
  for (Eigen::Index k = 0; k < columns.cols(); ++k) {
    double sum = 0, square = 0, count = 0;
    for (Eigen::Index row = 0; row < columns.rows(); ++row)
      if (const double value = columns(row, k); std::isfinite(value)) {
        sum += value, square += value * value, count += 1;
      }
    sizes[k] = count > 0 ? std::sqrt(std::max(0.0, square / count - sum * sum / count / count)) : 0;
  }
  return sizes;
}

// 0.1 % point of chi-squared by the approximation of Wilson and Hilferty (1931): within 1 % from
// one degree of freedom on.
double chi_squared_999(double dof) {
  const double ninth = 2 / (9 * dof);
  return dof * std::pow(1 - ninth + kNormal999 * std::sqrt(ninth), 3);
}

// "q1 says 41 arcsec, q2 -310 arcsec", by the term that weighs most.
std::string what_each_says(const diagnosis::Finding& finding, const InstrumentClaim& claim,
                           const Eigen::VectorXd& sizes) {
  Eigen::Index most = 0;
  (claim.seen_mm.colwise().norm().transpose().array() * sizes.array()).maxCoeff(&most);
  const auto physical = physical_of(finding.terms[static_cast<std::size_t>(most)]);
  std::string text;
  for (std::size_t o = 0; o < claim.outputs.size(); ++o) {
    const auto at = static_cast<Eigen::Index>(o);
    const double slope = claim.slopes(at, 0), seen = claim.seen_mm(at, most);
    const double largest = claim.slopes.col(0).cwiseAbs().maxCoeff();
    text += fmt::format("{}{} ", text.empty() ? "" : ", ", claim.outputs[o].symbol);
    if (claim.axes.size() == 1 && std::abs(slope) > 0.05 * largest)
      text += "says " + with_unit(-physical.factor * nm_from_mm(seen) / slope, physical.unit);
    else
      text += fmt::format("shows {:.3g} nm that this axis cannot bring there",
                          nm_from_mm(std::abs(seen) * sizes[most]));
  }
  return fmt::format("{} ({})", text, physical.what);
}

Result<void> check_agreement(int number, const diagnosis::Finding& finding,
                             const InstrumentClaim& claim, const Dataset& data) {
  const auto sizes = sizes_of(finding.terms, data);
  if (!sizes) return {};
  const Eigen::MatrixXd rest = claim.seen_mm + claim.slopes * claim.error_mm;  // c + S e
  double chi2 = 0, rest_nm2 = 0, all_nm2 = 0, largest_se2 = 0;
  Eigen::Index used = 0;
  std::vector<std::pair<double, double>> rest_and_se;  // nm^2 of each output
  for (std::size_t o = 0; o < claim.outputs.size(); ++o) {
    const auto found = std::ranges::find(finding.outputs, claim.outputs[o].symbol,
                                         &diagnosis::FindingOutput::output);
    if (found == finding.outputs.end() || found->coefficients.size() != finding.terms.size())
      continue;
    const auto at = static_cast<Eigen::Index>(o);
    const double seen2 = (claim.seen_mm.row(at).transpose().array() * sizes->array() * kNmPerMm)
                             .matrix()
                             .squaredNorm();
    const double left2 =
        (rest.row(at).transpose().array() * sizes->array() * kNmPerMm).matrix().squaredNorm();
    rest_and_se.emplace_back(left2, seen2 / std::max(1.0, found->gain_2lnl));
    largest_se2 = std::max(largest_se2, rest_and_se.back().second);
    all_nm2 += seen2, rest_nm2 += left2, ++used;
  }
  const auto dof = static_cast<double>((used - static_cast<Eigen::Index>(claim.axes.size())) *
                                       static_cast<Eigen::Index>(finding.terms.size()));
  if (dof < 1 || all_nm2 <= 0 || largest_se2 <= 0) return {};
  for (const auto& [left2, se2] : rest_and_se) chi2 += left2 / (se2 > 0 ? se2 : largest_se2);
  if (chi2 <= chi_squared_999(dof) ||
      rest_nm2 < kShareOfDisagreement * kShareOfDisagreement * all_nm2)
    return {};
  return fail(
      ErrorCode::failed_precondition, reasons::kOutputsDisagree,
      fmt::format("{}: the outputs do not agree on one instrument: {}. One correction would "
                  "leave {:.0f} % of it. Look for a cause in the robot, or accept other "
                  "findings",
                  named(number, finding), what_each_says(finding, claim, *sizes),
                  100 * std::sqrt(rest_nm2 / all_nm2)));
}

}  // namespace

Result<void> check_instrument(int number, const diagnosis::Finding& finding,
                              const InstrumentClaim& claim, const Dataset& data) {
  if (auto ok = check_possible(number, finding, claim); !ok) return ok;
  return check_agreement(number, finding, claim, data);
}

}  // namespace driftwise::application
