#include "server/diagnosis/noise/robust.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace driftwise::diagnosis {

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double robust_sd(std::vector<double> values) {
  constexpr double kMadToSd = 1.4826;
  for (auto& value : values) value = std::abs(value);
  return kMadToSd * median(std::move(values));
}

}  // namespace driftwise::diagnosis
