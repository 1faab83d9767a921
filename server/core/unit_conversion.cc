#include "server/core/unit_conversion.h"

#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise {
namespace {

enum class Kind {
  length,
  angle,
  temperature,
  force,
  pressure,
  ratio,
  voltage,
  current,
  power,
  rate,
  time
};

// base = value * numerator / denominator + offset, in metres, arcseconds, kelvins, newtons,
// pascals, 1, volts, amperes, watts, hertz, seconds. By definition (SI brochure, 9th edition,
// tables 4, 7 and 8; inch and degree Fahrenheit: NIST SP 811, appendix B.8).
struct UnitEntry {
  std::string_view name;
  Kind kind;
  double numerator, denominator, offset;
};

constexpr std::array kUnits = {
    UnitEntry{"m", Kind::length, 1, 1, 0},
    UnitEntry{"mm", Kind::length, 1, 1e3, 0},
    UnitEntry{"um", Kind::length, 1, 1e6, 0},
    UnitEntry{"nm", Kind::length, 1, 1e9, 0},
    UnitEntry{"inch", Kind::length, 254, 1e4, 0},
    UnitEntry{"mil", Kind::length, 254, 1e7, 0},
    UnitEntry{"rad", Kind::angle, 648000, std::numbers::pi, 0},
    UnitEntry{"mrad", Kind::angle, 648, std::numbers::pi, 0},
    UnitEntry{"urad", Kind::angle, 0.648, std::numbers::pi, 0},
    UnitEntry{"deg", Kind::angle, 3600, 1, 0},
    UnitEntry{"arcmin", Kind::angle, 60, 1, 0},
    UnitEntry{"arcsec", Kind::angle, 1, 1, 0},
    UnitEntry{"K", Kind::temperature, 1, 1, 0},
    UnitEntry{"degC", Kind::temperature, 1, 1, 273.15},
    UnitEntry{"degF", Kind::temperature, 5, 9, 459.67 * 5 / 9},
    UnitEntry{"N", Kind::force, 1, 1, 0},
    UnitEntry{"mN", Kind::force, 1, 1e3, 0},
    UnitEntry{"kN", Kind::force, 1e3, 1, 0},
    UnitEntry{"Pa", Kind::pressure, 1, 1, 0},
    UnitEntry{"hPa", Kind::pressure, 100, 1, 0},
    UnitEntry{"mbar", Kind::pressure, 100, 1, 0},
    UnitEntry{"kPa", Kind::pressure, 1e3, 1, 0},
    UnitEntry{"bar", Kind::pressure, 1e5, 1, 0},
    UnitEntry{"pct", Kind::ratio, 1, 100, 0},
    UnitEntry{"1", Kind::ratio, 1, 1, 0},
    UnitEntry{"V", Kind::voltage, 1, 1, 0},
    UnitEntry{"mV", Kind::voltage, 1, 1e3, 0},
    UnitEntry{"A", Kind::current, 1, 1, 0},
    UnitEntry{"mA", Kind::current, 1, 1e3, 0},
    UnitEntry{"W", Kind::power, 1, 1, 0},
    UnitEntry{"kW", Kind::power, 1e3, 1, 0},
    UnitEntry{"Hz", Kind::rate, 1, 1, 0},
    UnitEntry{"rpm", Kind::rate, 1, 60, 0},
    UnitEntry{"s", Kind::time, 1, 1, 0},
    UnitEntry{"ms", Kind::time, 1, 1e3, 0},
    UnitEntry{"us", Kind::time, 1, 1e6, 0},
    UnitEntry{"min", Kind::time, 60, 1, 0},
    UnitEntry{"h", Kind::time, 3600, 1, 0},
};

Result<UnitEntry> find_unit(std::string_view name) {
  std::string known;
  for (const auto& unit : kUnits) {
    if (unit.name == name) return unit;
    known += " " + std::string(unit.name);
  }
  return fail(ErrorCode::invalid_argument, reasons::kUnknownUnit,
              "found the unit '" + std::string(name) + "', expected one of" + known);
}

}  // namespace

std::optional<int> UnitConversion::decimal_shift() const {
  if (offset != 0) return std::nullopt;
  double up = factor, down = divisor;
  int shift = 0;
  for (; up > 1 && std::fmod(up, 10) == 0; up /= 10) ++shift;
  for (; down > 1 && std::fmod(down, 10) == 0; down /= 10) --shift;
  if (up != 1 || down != 1) return std::nullopt;
  return shift;
}

Result<UnitConversion> unit_conversion(std::string_view from, std::string_view to) {
  DRIFTWISE_TRY(const auto source, find_unit(from), target = find_unit(to));
  DRIFTWISE_RETURN_IF_ERROR(target);
  if (source.kind != target->kind)
    return fail(ErrorCode::invalid_argument, reasons::kUnitKind,
                "found " + std::string(from) + " for a quantity in " + std::string(to) +
                    ", expected a unit of the same kind");
  if (from == to) return UnitConversion{};
  UnitConversion out;
  out.factor = source.numerator * target->denominator;
  out.divisor = source.denominator * target->numerator;
  if (std::fmod(out.factor, out.divisor) == 0)
    out = {out.factor / out.divisor, 1, 0};
  else if (std::fmod(out.divisor, out.factor) == 0)
    out = {1, out.divisor / out.factor, 0};
  out.offset = (source.offset - target->offset) * target->denominator / target->numerator;
  return out;
}

}  // namespace driftwise
