#include "server/diagnosis/catalogue/parameter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace driftwise::diagnosis {
namespace {

constexpr double kDrop90 = 2.7055, kDropOfCurve = 10;
constexpr int kGoldenSteps = 14, kBisections = 50, kCurvePointsPerSide = 8;
constexpr double kOfInterval = 5e-3;  // how well its ends are found

struct Scale {
  bool inverse;
  double to(double value) const { return inverse ? 1 / value : std::log(value); }
  double from(double u) const { return inverse ? 1 / u : std::exp(u); }
};

bool is_continuous(const Cause& cause) {
  return cause.cells.size() >= 3 &&
         (cause.scale == ParameterScale::logarithmic || cause.scale == ParameterScale::inverse);
}

// The values of the grid next to one, on either side.
std::pair<double, double> neighbours(const Cause& cause, double value) {
  double below = -INFINITY, above = INFINITY;
  for (const auto& cell : cause.cells) {
    const double v = cell.parameter;
    if (v < value * (1 - 1e-9)) below = std::max(below, v);
    if (v > value * (1 + 1e-9)) above = std::min(above, v);
  }
  return {std::isfinite(below) ? below : value, std::isfinite(above) ? above : value};
}

Refined best_instant(const Cause& cause, double start, const std::vector<double>& instants,
                     const GainOf& gain) {
  const auto [below, above] = neighbours(cause, start);
  Refined best{start, gain(start)};
  for (auto at = std::ranges::lower_bound(instants, below); at != instants.end() && *at <= above;
       ++at) {
    const double here = gain(*at);
    if (here > best.gain) best = {*at, here};
  }
  return best;
}

// Where the gain has dropped by `drop`, from the best towards a limit, on the scale u.
double end_of(double best_u, double top, double drop, double step, double limit,
              const std::function<double(double)>& gain_u) {
  double inside = best_u, outside = best_u;
  while (true) {
    outside = step < 0 ? std::max(outside + step, limit) : std::min(outside + step, limit);
    if (gain_u(outside) < top - drop) break;
    inside = outside;
    if (outside == limit) return limit;
    step *= 1.7;
  }
  for (int i = 0;
       i < kBisections && std::abs(outside - inside) > kOfInterval * std::abs(outside - best_u);
       ++i) {
    const double middle = (inside + outside) / 2;
    (gain_u(middle) < top - drop ? outside : inside) = middle;
  }
  return (inside + outside) / 2;
}

Profile of_instants(const Refined& at, const std::vector<double>& instants, const GainOf& gain) {
  Profile result{{at.value, at.value}, {{at.value, 0}}};
  const auto middle = std::ranges::lower_bound(instants, at.value) - instants.begin();
  for (const int direction : {-1, 1}) {
    bool within = true;
    double last = at.value;
    auto& end = direction < 0 ? result.ci90.low : result.ci90.high;
    for (std::ptrdiff_t i = middle + direction;
         i >= 0 && i < static_cast<std::ptrdiff_t>(instants.size()); i += direction) {
      const double value = instants[static_cast<std::size_t>(i)];
      const double below = at.gain - gain(value);
      result.curve.push_back({value, std::max(below, 0.0)});
      if (within && below >= kDrop90) {
        within = false;
        end = (last + value) / 2;  // the row between the last possible instant and this one
      }
      last = value;
      if (below > kDropOfCurve) break;
    }
    if (within) end = last;
  }
  std::ranges::sort(result.curve, {}, &CurvePoint::value);
  return result;
}

}  // namespace

Refined refine(const Cause& cause, double start, const std::vector<double>& instants,
               const GainOf& gain) {
  if (cause.scale == ParameterScale::instant) return best_instant(cause, start, instants, gain);
  if (!is_continuous(cause)) return {start, gain(start)};
  const Scale scale{cause.scale == ParameterScale::inverse};
  const auto [below, above] = neighbours(cause, start);
  double low = scale.to(below), high = scale.to(above);
  if (low > high) std::swap(low, high);
  const double golden = (std::sqrt(5.0) - 1) / 2;
  double a = high - golden * (high - low), b = low + golden * (high - low);
  double at_a = gain(scale.from(a)), at_b = gain(scale.from(b));
  for (int i = 0; i < kGoldenSteps; ++i) {
    if (at_a > at_b) {
      high = b;
      b = a;
      at_b = at_a;
      a = high - golden * (high - low);
      at_a = gain(scale.from(a));
    } else {
      low = a;
      a = b;
      at_a = at_b;
      b = low + golden * (high - low);
      at_b = gain(scale.from(b));
    }
  }
  Refined best{start, gain(start)};
  if (at_a > best.gain) best = {scale.from(a), at_a};
  if (at_b > best.gain) best = {scale.from(b), at_b};
  return best;
}

double as_written(const Cause& cause, double value) {
  constexpr int kFewestDigits = 6;
  constexpr double kToldApart = 1e-4;  // of the interval that the search begins with
  if (!is_continuous(cause) || !(value > 0)) return value;
  const auto [below, above] = neighbours(cause, value);
  if (!(above > below)) return value;
  const double needed = std::ceil(std::log10(value / (kToldApart * (above - below))));
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%.*e",
                std::max(kFewestDigits, static_cast<int>(needed)) - 1, value);
  return std::strtod(text.data(), nullptr);
}

std::optional<Profile> profile(const Cause& cause, const Refined& at,
                               const std::vector<double>& instants, const GainOf& gain) {
  if (cause.scale == ParameterScale::instant) return of_instants(at, instants, gain);
  if (!is_continuous(cause)) return std::nullopt;
  const Scale scale{cause.scale == ParameterScale::inverse};
  double first = scale.to(cause.cells.front().parameter);
  double last = scale.to(cause.cells.back().parameter);
  if (first > last) std::swap(first, last);
  const double best = scale.to(at.value);
  const auto gain_u = [&](double u) { return gain(scale.from(u)); };
  // From cell to cell about the best: known periods make the grid a thousand times coarser
  // elsewhere.
  const auto [below, above] = neighbours(cause, at.value);
  double grid_step = (last - first) / static_cast<double>(cause.cells.size() - 1);
  for (const double next : {below, above})
    if (const double away = std::abs(scale.to(next) - best); away > 0)
      grid_step = std::min(grid_step, away);
  const double low =
      end_of(best, at.gain, kDrop90, -0.1 * grid_step, std::min(first, best), gain_u);
  const double high = end_of(best, at.gain, kDrop90, 0.1 * grid_step, std::max(last, best), gain_u);
  Profile result{{scale.from(low), scale.from(high)}, {{at.value, 0}}};
  if (result.ci90.low > result.ci90.high) std::swap(result.ci90.low, result.ci90.high);
  // twice as far as the interval goes: a drop of about 11 where the curve is a parabola
  for (int i = 1; i <= kCurvePointsPerSide; ++i)
    for (const double end : {low, high}) {
      const double u = std::clamp(best + (end - best) * 2 * i / kCurvePointsPerSide, first, last);
      const CurvePoint point{scale.from(u), std::max(at.gain - gain_u(u), 0.0)};
      if (std::ranges::find(result.curve, point.value, &CurvePoint::value) == result.curve.end())
        result.curve.push_back(point);
    }
  std::ranges::sort(result.curve, {}, &CurvePoint::value);
  return result;
}

}  // namespace driftwise::diagnosis
