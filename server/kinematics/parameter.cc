#include "server/kinematics/parameter.h"

#include <string_view>

#include "server/core/reasons.h"

namespace driftwise::kinematics {
namespace {

// Back to the last star only: linear in the pattern for each letter of the name.
bool matches(std::string_view pattern, std::string_view name) {
  std::size_t p = 0, n = 0, star = std::string_view::npos, resume = 0;
  while (n < name.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      resume = n;
    } else if (p < pattern.size() && pattern[p] == name[n]) {
      ++p;
      ++n;
    } else if (star != std::string_view::npos) {
      p = star + 1;
      n = ++resume;
    } else {
      return false;
    }
  }
  return pattern.find_first_not_of('*', p) == std::string_view::npos;
}

}  // namespace

Eigen::VectorXd nominal_values(const Parameters& parameters) {
  Eigen::VectorXd values(static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t i = 0; i < parameters.size(); ++i)
    values[static_cast<Eigen::Index>(i)] = parameters[i].nominal;
  return values;
}

Result<void> hold(Parameters& parameters, const std::vector<std::string>& patterns) {
  for (const auto& pattern : patterns) {
    bool any = false;
    for (auto& parameter : parameters) {
      if (!matches(pattern, parameter.name)) continue;
      parameter.held = any = true;
    }
    if (any) continue;
    std::string known;
    for (const auto& parameter : parameters) known += (known.empty() ? "" : " ") + parameter.name;
    return fail(ErrorCode::invalid_argument, reasons::kUnknownParameter,
                "hold: found '" + pattern.substr(0, 80) +
                    "', which names no parameter of this robot; it has: " + known);
  }
  return {};
}

}  // namespace driftwise::kinematics
