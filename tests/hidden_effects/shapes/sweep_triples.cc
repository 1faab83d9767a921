#include "tests/hidden_effects/shapes/sweep_triples.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>

namespace driftwise::hidden {
namespace {

using Names = std::array<const char*, 3>;

constexpr std::array<Names, 20> kTriples = {{
    {"thermal_lag", "backlash", "step_change"},
    {"thermal_lag", "cyclic_error", "periodic_disturbance"},
    {"thermal_lag", "abbe_offset", "backlash"},
    {"thermal_offset", "backlash", "cyclic_error"},
    {"thermal_offset", "creep", "step_change"},
    {"thermal_offset", "geometry_order", "periodic_disturbance"},
    {"thermal_rate", "backlash", "cyclic_error"},
    {"thermal_rate", "geometry_order", "creep"},
    {"thermal_expansion", "backlash", "periodic_disturbance"},
    {"thermal_expansion", "creep", "cyclic_error"},
    {"thermal_expansion", "geometry_order", "step_change"},
    {"thermal_expansion", "abbe_offset", "cyclic_error"},
    {"self_heating", "backlash", "cyclic_error"},
    {"self_heating", "geometry_order", "step_change"},
    {"backlash", "creep", "periodic_disturbance"},
    {"creep", "cosine_error", "cyclic_error"},
    {"geometry_order", "cyclic_error", "instrument_drift"},
    {"refractive_index", "backlash", "step_change"},
    {"refractive_index", "geometry_order", "periodic_disturbance"},
    {"instrument_drift", "creep", "periodic_disturbance"},
}};

}  // namespace

std::vector<std::vector<Hidden>> triples_of(const std::vector<Hidden>& all) {
  std::vector<std::vector<Hidden>> triples;
  for (const auto& names : kTriples) {
    auto& three = triples.emplace_back();
    for (const std::string name : names) {
      const auto one = std::ranges::find(all, name, &Hidden::cause);
      if (one == all.end()) throw std::out_of_range("nothing hides " + name);
      three.push_back(*one);
    }
  }
  return triples;
}

}  // namespace driftwise::hidden
