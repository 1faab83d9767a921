#include "server/diagnosis/rows/aliases.h"

#include <algorithm>
#include <cmath>

namespace driftwise::diagnosis {

namespace {

// Middles of what lies closer together than `loose` allows of one place, ascending.
std::vector<double> distinct_places(std::vector<double> values, double loose) {
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  std::ranges::sort(values);
  std::vector<double> places;
  for (std::size_t i = 0; i < values.size();) {
    std::size_t end = i + 1;
    double sum = values[i];
    while (end < values.size() && values[end] - values[end - 1] <= 2 * loose) sum += values[end++];
    places.push_back(sum / static_cast<double>(end - i));
    i = end;
  }
  return places;
}

}  // namespace

double lattice_spacing(const std::vector<double>& values, double loose) {
  const auto places = distinct_places(values, loose);
  if (places.size() < 3) return 0;
  // The closest neighbours give the spacing roughly; each place further out, counted in it, gives
  // it better, so that the count never slips over a long range.
  double spacing = places[1] - places[0];
  for (std::size_t i = 2; i < places.size(); ++i)
    spacing = std::min(spacing, places[i] - places[i - 1]);
  for (std::size_t i = 1; i < places.size(); ++i)
    if (const double steps = std::round((places[i] - places[0]) / spacing); steps > 0)
      spacing = (places[i] - places[0]) / steps;
  for (const double value : values)
    if (std::isfinite(value) &&
        std::abs(std::remainder(value - places.front(), spacing)) > 2 * loose)
      return 0;
  return spacing;
}

std::vector<double> aliased_periods(double period, double spacing) {
  std::vector<double> periods;
  if (!(spacing > 0) || !(period > 0)) return periods;
  for (int k = 1; k <= 3; ++k)
    for (const double sign : {-1.0, 1.0}) {
      const double waves = k / spacing + sign / period;
      if (waves > 1e-9 / spacing && std::abs(waves * period - 1) > 1e-6)
        periods.push_back(1 / waves);
    }
  std::ranges::sort(periods, std::greater<>());
  return periods;
}

std::vector<double> alike_on_a_lattice(double period, double spacing) {
  if (!(spacing > 0) || !(period > 0)) return {};
  constexpr double kSame = 1e-3;                                       // of a period
  const double turns = std::abs(std::remainder(spacing / period, 1));  // from place to place
  if (turns < kSame) return {};                                        // a constant on this lattice
  const double longest = spacing / turns;
  std::vector<double> periods = aliased_periods(longest, spacing);
  periods.insert(periods.begin(), longest);
  std::erase_if(periods, [&](double one) { return std::abs(one / period - 1) < kSame; });
  return periods;
}

}  // namespace driftwise::diagnosis
