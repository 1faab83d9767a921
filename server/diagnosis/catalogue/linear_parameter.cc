#include "server/diagnosis/catalogue/linear_parameter.h"

#include <algorithm>

#include "server/core/units.h"
#include "server/effects/term_order.h"

namespace driftwise::diagnosis {
namespace {

bool is_air_index(const effects::Term& term) {
  const auto* call = std::get_if<effects::Call>(&term.factors.front());
  return call != nullptr && call->effect == "air_index";
}

// Per arcsec of a rotation, which is no share of a length.
bool of_rotation(const effects::Term& term) {
  return std::ranges::any_of(effects::symbols_of(term), [](const std::string& symbol) {
    return symbol == "rx" || symbol == "ry" || symbol == "rz";
  });
}

}  // namespace

LinearNumber linear_number(LinearParameter parameter, const effects::Term& term, double value) {
  switch (parameter) {
    case LinearParameter::none:
      return {};
    case LinearParameter::nm_per_k:
      return {"nm_per_k", 1};
    case LinearParameter::nm_per_k_per_h:
      return {"nm_per_k_per_h", 1};
    case LinearParameter::ppm_per_k:  // nm per mm is ppm
      return of_rotation(term) ? LinearNumber{} : LinearNumber{"ppm_per_k", 1};
    case LinearParameter::nm_per_n:
      return {"nm_per_n", 1};
    case LinearParameter::nm_per_n_per_mm:
      return of_rotation(term) ? LinearNumber{} : LinearNumber{"nm_per_n_per_mm", 1};
    case LinearParameter::width_nm:  // the play's own output is in mm for a width of `value` nm
      return {"width_nm", value / kNmPerMm};
    case LinearParameter::offset_mm:  // nm per arcsec
      return {"offset_mm", 1 / (kRadPerArcsec * kNmPerMm)};
    case LinearParameter::angle_arcsec:  // nm per mm and arcsec; a tilt alone is the beam's start
      if (term.factors.size() < 2) return {};
      return {"angle_arcsec", 1 / (kRadPerArcsec * kRadPerArcsec * kNmPerMm)};
    case LinearParameter::dead_path_mm:  // nm per ppm
      return is_air_index(term) ? LinearNumber{"dead_path_mm", 1} : LinearNumber{};
    case LinearParameter::nm_per_h:
      if (of_rotation(term)) return {};
      return term.factors.size() > 1 ? LinearNumber{"ppm_per_h", 1} : LinearNumber{"nm_per_h", 1};
    case LinearParameter::size_nm:
      return {"size_nm", 1};
  }
  return {};
}

}  // namespace driftwise::diagnosis
