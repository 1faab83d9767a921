#include "drivers/watlow_ez_zone/registers.h"

#include <algorithm>
#include <bit>

#include "server/core/units.h"

namespace driftwise::watlow {

constexpr double kDegfPerKelvin = 1.8;

std::array<std::uint16_t, 2> pack_float(float value, WordOrder order) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  const auto high = static_cast<std::uint16_t>(bits >> 16),
             low = static_cast<std::uint16_t>(bits & 0xffff);
  if (order == WordOrder::low_first) return {low, high};
  return {high, low};
}

float unpack_float(std::span<const std::uint16_t, 2> registers, WordOrder order) {
  const std::uint32_t high = registers[order == WordOrder::low_first ? 1 : 0];
  const std::uint32_t low = registers[order == WordOrder::low_first ? 0 : 1];
  return std::bit_cast<float>(high << 16 | low);
}

double degc_from_wire(float value, Unit unit) {
  return unit == Unit::celsius ? static_cast<double>(value)
                               : degc_from_degf(static_cast<double>(value));
}

float wire_from_degc(double degc, Unit unit) {
  return static_cast<float>(unit == Unit::celsius ? degc : degf_from_degc(degc));
}

double kelvin_from_wire(float value, Unit unit) {
  return static_cast<double>(value) / (unit == Unit::celsius ? 1.0 : kDegfPerKelvin);
}

float wire_from_kelvin(double kelvin, Unit unit) {
  return static_cast<float>(kelvin * (unit == Unit::celsius ? 1.0 : kDegfPerKelvin));
}

bool is_plausible(double degc) { return degc >= kPlausibleMinDegc && degc <= kPlausibleMaxDegc; }

std::string describe_input_error(std::uint16_t code) {
  const char* text = code == kInputGood ? " (none)" : code == 65 ? " (open)" : "";
  return std::to_string(code) + text;
}

std::string describe_unit(std::uint16_t code) {
  const char* text = code == kUnitFahrenheit ? " (F)" : code == kUnitCelsius ? " (C)" : "";
  return std::to_string(code) + text;
}

}  // namespace driftwise::watlow
