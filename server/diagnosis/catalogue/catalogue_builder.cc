#include "server/diagnosis/catalogue/catalogue_builder.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "server/effects/effect.h"
#include "server/effects/term_order.h"

namespace driftwise::diagnosis {
namespace {

constexpr int kPerDecade = 7;  // of a time constant or a width

// What a machine does, as a channel says it: speed in rpm, current in A, power in W, duty.
bool is_activity(const Channel& channel) {
  static constexpr std::array kUnits = {"rpm", "Hz", "A", "W", "V", "pct", "1"};
  static constexpr std::array kNot = {"air", "pressure", "humidity", "dwell"};
  const std::string& symbol = channel.symbol;
  return std::ranges::find(kUnits, channel.unit) != kUnits.end() &&
         std::ranges::none_of(kNot, [&](const char* one) { return symbol.starts_with(one); }) &&
         !symbol.ends_with("_set") && !symbol.ends_with("_cmd") && !symbol.ends_with("_std");
}

}  // namespace

StraightLine straight_line(std::span<const double> from, std::span<const double> to) {
  std::vector<std::pair<double, double>> rows;
  double mean_from = 0, mean_to = 0;
  for (std::size_t row = 0; row < std::min(from.size(), to.size()); ++row) {
    if (!std::isfinite(from[row]) || !std::isfinite(to[row])) continue;
    rows.emplace_back(from[row], to[row]);
    mean_from += from[row];
    mean_to += to[row];
  }
  if (rows.empty()) return {};
  const auto count = static_cast<double>(rows.size());
  mean_from /= count;
  mean_to /= count;
  double aa = 0, ab = 0, bb = 0;
  for (const auto& [a, b] : rows) {
    aa += (a - mean_from) * (a - mean_from);
    ab += (a - mean_from) * (b - mean_to);
    bb += (b - mean_to) * (b - mean_to);
  }
  if (!(aa > 0)) return {};
  return {.slope = ab / aa,
          .left_rms = std::sqrt(std::max(bb - ab * ab / aa, 0.0) / count),
          .correlation = bb > 0 ? ab / std::sqrt(aa * bb) : 0};
}

double wave_step(double range, std::size_t half_turns) {
  constexpr std::size_t kMostFine = 2000;  // half turns: memory and time of the scan's columns
  return 1 / ((half_turns <= kMostFine ? 4 : 2) * range);
}

std::vector<double> log_grid(double low, double high) {
  std::vector<double> values;
  if (!(high > low) || !(low > 0)) return values;
  const int steps = std::max(1, static_cast<int>(std::ceil(std::log10(high / low) * kPerDecade)));
  for (int i = 0; i <= steps; ++i) values.push_back(low * std::pow(high / low, i / double(steps)));
  return values;
}

effects::Term power_term(const std::string& symbol, int exponent) {
  return {{effects::Power{symbol, exponent}}};
}

std::vector<effects::Term> monomials_of_degree(const std::vector<std::string>& axes, int degree) {
  std::vector<effects::Term> terms;
  const auto fill = [&](const auto& self, std::size_t at, int left, const effects::Term& so_far) {
    if (at == axes.size()) {
      if (left == 0) terms.push_back(so_far);
      return;
    }
    for (int e = left; e >= 0; --e)
      self(self, at + 1, left - e,
           e > 0 ? effects::product(so_far, power_term(axes[at], e)) : so_far);
  };
  fill(fill, 0, degree, {});
  return terms;
}

effects::Term call_term(const std::string& effect, std::vector<std::string> symbols,
                        std::vector<effects::Quantity> parameters) {
  return {{effects::Call{effect, std::move(symbols), std::move(parameters)}}};
}

CatalogueBuilder::CatalogueBuilder(const Dataset& dataset, const std::vector<effects::Term>& base,
                                   const std::vector<std::string>& excluded)
    : dataset_(dataset), excluded_(excluded.begin(), excluded.end()) {
  std::set<std::string> read;
  for (const auto& term : base) {
    known_.insert(effects::notation(effects::canonical(term)));
    for (const auto& symbol : effects::symbols_of(term)) read.insert(symbol);
  }
  // Lengths make a rotation a tilt; without any it is where a table stands.
  const bool any_length = std::ranges::any_of(
      dataset.columns, [](const DatasetColumn& column) { return is_length(column.channel.unit); });
  for (const auto& column : dataset.columns) {
    const auto& channel = column.channel;
    if (!varies(channel.symbol)) continue;
    const bool pose = is_pose_symbol(channel.symbol);
    if (is_activity(channel)) activities_.push_back(channel.symbol);
    if (is_structure_temperature(channel)) temperatures_.push_back(channel.symbol);
    const bool length = channel.unit == "mm", angle = channel.unit == "arcsec";
    if (length && pose) lengths_.push_back(channel.symbol);
    if (angle && pose && any_length) tilts_.push_back(channel.symbol);
    if (pose && (length || (angle && (!any_length || read.contains(channel.symbol)))))
      axes_.push_back(channel.symbol);
    if ((length || angle) && is_motor_symbol(channel.symbol)) motors_.push_back(channel.symbol);
  }
  if (!dataset.time_s.empty()) {
    const auto [low, high] = std::ranges::minmax_element(dataset.time_s);
    length_s_ = *high - *low;
    std::vector<double> steps;
    for (std::size_t i = 1; i < dataset.rows; ++i)
      steps.push_back(dataset.time_s[i] - dataset.time_s[i - 1]);
    if (!steps.empty()) {
      std::ranges::nth_element(steps,
                               steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2));
      step_s_ = std::max(steps[steps.size() / 2], length_s_ / 1e6);
    }
  }
}

bool CatalogueBuilder::is_angle(const std::string& symbol) const {
  const auto* column = dataset_.find(symbol);
  return column != nullptr && column->channel.unit == "arcsec";
}

bool CatalogueBuilder::varies(const std::string& symbol) const { return range(symbol) > 0; }

double CatalogueBuilder::range(const std::string& symbol) const {
  if (excluded_.contains(symbol)) return 0;
  double low = INFINITY, high = -INFINITY;
  for (const double value : dataset_.values_of(symbol)) {
    if (!std::isfinite(value)) continue;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  return std::max(high - low, 0.0);
}

bool CatalogueBuilder::known(const effects::Term& term) const {
  return known_.contains(effects::notation(effects::canonical(term)));
}

void CatalogueBuilder::missing(const std::string& cause, const std::string& why) {
  for (auto& one : catalogue_.not_testable)
    if (one.cause == cause) {
      if (one.why.find(why) == std::string::npos) one.why += "; " + why;
      return;
    }
  catalogue_.not_testable.push_back({cause, why});
}

namespace {

// A week between rows, or a stroke of a picometre, asks for what no formula may say.
bool are_within_limits(const std::vector<effects::Term>& terms) {
  return std::ranges::all_of(terms, [](const effects::Term& term) {
    return std::ranges::all_of(term.factors, [](const effects::Factor& factor) {
      const auto* call = std::get_if<effects::Call>(&factor);
      return call == nullptr || effects::checked(*call).has_value();
    });
  });
}

}  // namespace

void CatalogueBuilder::add_terms(Cause& cause, const std::vector<effects::Term>& terms,
                                 double parameter) const {
  Cell cell{parameter, {}};
  for (const auto& term : terms)
    if (!known(term)) cell.terms.push_back(effects::canonical(term));
  if (cell.terms.empty() || !are_within_limits(cell.terms)) return;
  for (const auto& other : cause.cells)
    if (other.terms == cell.terms) return;
  cause.cells.push_back(std::move(cell));
}

void CatalogueBuilder::add_values(Cause& cause, const std::vector<double>& values,
                                  const std::function<std::vector<effects::Term>(double)>& terms) {
  bool any = false;
  for (const double value : values) {
    Cell cell{value, terms(value)};
    if (are_within_limits(cell.terms)) cause.cells.push_back(std::move(cell)), any = true;
  }
  if (!values.empty() && !any)
    missing(cause.id, "every " + cause.parameter + " that these data could show, from " +
                          effects::number_text(values.front()) + " to " +
                          effects::number_text(values.back()) + ", is outside its limits");
}

void CatalogueBuilder::take_cause(Cause cause) {
  if (!cause.cells.empty()) catalogue_.causes.push_back(std::move(cause));
}

}  // namespace driftwise::diagnosis
