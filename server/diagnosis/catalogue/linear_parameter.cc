#include "server/diagnosis/catalogue/linear_parameter.h"

#include <algorithm>

#include "server/core/channel.h"
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

// Of a product with more than one pose coordinate, or a power of one: no number per millimetre.
bool of_higher_order(const effects::Term& term) {
  int degree = 0;
  for (const auto& factor : term.factors)
    if (const auto* power = std::get_if<effects::Power>(&factor);
        power != nullptr && is_pose_symbol(power->symbol))
      degree += power->exponent;
  return degree > 1;
}

// Of one of the air's channels where not all three are there, alone or times a length: what it does
// to the zero, or to the length.
LinearNumber of_air(const effects::Term& term) {
  const auto read = effects::symbols_of(term);
  const bool of_length = term.factors.size() > 1;
  if (of_rotation(term) || of_higher_order(term)) return {};
  for (const auto& symbol : read) {
    if (symbol == "air") return {of_length ? "ppm_per_k" : "nm_per_k", 1};
    if (symbol == "pressure") return {of_length ? "ppm_per_hpa" : "nm_per_hpa", 1};
    if (symbol == "humidity") return {of_length ? "ppm_per_pct" : "nm_per_pct", 1};
  }
  return {};
}

}  // namespace

bool is_square(const effects::Term& term) {
  const auto* power = std::get_if<effects::Power>(&term.factors.front());
  return term.factors.size() == 1 && power != nullptr && power->exponent == 2;
}

LinearNumber linear_number_of_angle(LinearParameter parameter, const effects::Term& term,
                                    double value) {
  switch (parameter) {
    case LinearParameter::width_arcsec:
      return {"width_arcsec", value};
    case LinearParameter::size_nm:
      return {"size_arcsec", 1};
    case LinearParameter::nm_per_k:
      return {"arcsec_per_k", 1};
    case LinearParameter::nm_per_k_per_h:
      return {"arcsec_per_k_per_h", 1};
    case LinearParameter::nm_per_n:
      return {"arcsec_per_n", 1};
    case LinearParameter::nm_per_h:  // of the zero; of a scale there is no number
      return term.factors.size() > 1 ? LinearNumber{} : LinearNumber{"arcsec_per_h", 1};
    default:
      return {};
  }
}

LinearNumber linear_number(LinearParameter parameter, const effects::Term& term, double value) {
  switch (parameter) {
    case LinearParameter::none:
    case LinearParameter::width_arcsec:
      return {};
    case LinearParameter::nm_per_k:
      return {"nm_per_k", 1};
    case LinearParameter::nm_per_k_per_h:
      return {"nm_per_k_per_h", 1};
    case LinearParameter::ppm_per_k:  // nm per mm is ppm
      if (of_rotation(term) || of_higher_order(term)) return {};
      return {"ppm_per_k", 1};
    case LinearParameter::nm_per_n:
      return {"nm_per_n", 1};
    case LinearParameter::nm_per_n_per_mm:
      if (of_rotation(term) || of_higher_order(term)) return {};
      return {"nm_per_n_per_mm", 1};
    case LinearParameter::width_nm:  // the play's own output is in mm for a width of `value` nm
      if (of_rotation(term)) return {};
      return {term.factors.size() > 1 ? "width_nm_per_mm" : "width_nm", value / kNmPerMm};
    case LinearParameter::offset_mm:  // nm per arcsec
      return {"offset_mm", 1 / (kRadPerArcsec * kNmPerMm)};
    case LinearParameter::angle_arcsec:  // nm per mm and arcsec; a tilt alone is the beam's start
      if (is_square(term)) return {"dead_path_mm", 2 / (kRadPerArcsec * kRadPerArcsec * kNmPerMm)};
      if (term.factors.size() < 2) return {};
      return {"angle_arcsec", 1 / (kRadPerArcsec * kRadPerArcsec * kNmPerMm)};
    case LinearParameter::dead_path_mm:  // nm per ppm
      return is_air_index(term) ? LinearNumber{"dead_path_mm", 1} : of_air(term);
    case LinearParameter::nm_per_h:
      if (of_rotation(term)) return {};
      return term.factors.size() > 1 ? LinearNumber{"ppm_per_h", 1} : LinearNumber{"nm_per_h", 1};
    case LinearParameter::size_nm:
      return {"size_nm", 1};
  }
  return {};
}

}  // namespace driftwise::diagnosis
