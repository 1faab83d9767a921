#pragma once
// From one unit to another of the same kind, for measurements that come from elsewhere: lengths,
// angles, temperatures, forces, pressures, ratios, voltages, currents, powers, rates, times. Knows
// every channel unit (channel.h) and the usual foreign ones: inch, mil, mrad, urad, arcmin, degF,
// mN, kN, kPa, bar, mbar, mV, mA, kW, ms, us, min, h.

#include <optional>
#include <string_view>

#include "server/core/result.h"

namespace driftwise {

// to = from * factor / divisor + offset. Between whole multiples one of factor and divisor is 1.
struct UnitConversion {
  double factor = 1, divisor = 1, offset = 0;
  double operator()(double value) const { return value * factor / divisor + offset; }
  // 3 from m to mm: a decimal text converts exactly by moving its point. Nothing when it is no
  // power of ten.
  std::optional<int> decimal_shift() const;
};

// Errors: invalid_argument; UNKNOWN_UNIT naming those known, UNIT_KIND when the two measure
// different things.
Result<UnitConversion> unit_conversion(std::string_view from, std::string_view to);

}  // namespace driftwise
