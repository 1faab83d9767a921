#include "tests/statistics/coverage_cases.h"

#include <stdexcept>

#include "tests/statistics/linear_axis_case.h"
#include "tests/statistics/micro_nano_case.h"

namespace driftwise::statistics {

std::vector<std::string> case_names() { return {"micro-nano", "linear-axis"}; }

std::function<SimulatedCase(std::uint64_t seed)> case_named(const std::string& name) {
  if (name == "linear-axis") return linear_axis_case;
  if (name == "micro-nano") return micro_nano_case;
  throw std::runtime_error("no simulated case '" + name + "'");
}

}  // namespace driftwise::statistics
