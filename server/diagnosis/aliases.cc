#include "server/diagnosis/aliases.h"

#include <algorithm>
#include <cmath>

namespace driftwise::diagnosis {

double lattice_spacing(const std::vector<double>& values, double loose) {
  std::vector<double> places;
  for (const double value : values)
    if (std::isfinite(value)) places.push_back(value);
  if (places.size() < 3) return 0;
  std::ranges::sort(places);
  // The closest of what is not the same place is the spacing, or a multiple of it.
  double spacing = 0;
  for (std::size_t i = 1; i < places.size(); ++i) {
    const double gap = places[i] - places[i - 1];
    if (gap > 2 * loose && (spacing == 0 || gap < spacing)) spacing = gap;
  }
  if (spacing == 0) return 0;
  // Over the whole range it must fit better than a gap of two loose ends tells.
  const double steps = std::round((places.back() - places.front()) / spacing);
  spacing = (places.back() - places.front()) / steps;
  for (const double place : places)
    if (std::abs(std::remainder(place - places.front(), spacing)) > 2 * loose) return 0;
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

}  // namespace driftwise::diagnosis
