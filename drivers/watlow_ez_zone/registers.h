#pragma once
// Watlow EZ-ZONE PM: registers and floats on Modbus, bytes <-> values. Pure. Addresses go on the
// wire as they stand; zone z is at +5000 (z - 1). Facts: PROTOCOLS.md section 4 (M, D); word order
// and unit are configuration.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "server/core/devices/device_description.h"

namespace driftwise::watlow {

enum class WordOrder { low_first, high_first };  // low first by default (M): 75.0 -> 0x0000, 0x4296
enum class Unit { fahrenheit, celsius };         // fahrenheit by default (M)

namespace address {
inline constexpr int kProcessValue = 360;  // float; 362 follows
inline constexpr int kInputError = 362;    // u16
inline constexpr int kMode = 1880;         // u16
inline constexpr int kHeatBand = 1890;     // float; cool band, integral, derivative follow
inline constexpr int kHeatPower = 1904;    // float, %
inline constexpr int kSetPoint = 2160;     // float
inline constexpr int kUnit = 2490;         // u16
inline constexpr int kZoneStride = 5000;
}  // namespace address

inline constexpr std::uint16_t kInputGood =
    61;  // 362: none; 65 open (U); anything but none is an error
inline constexpr std::uint16_t kModeAutomatic = 10, kModeManual = 54, kModeOff = 62;
inline constexpr std::uint16_t kUnitFahrenheit = 30, kUnitCelsius = 15;

// IEEE 754 single in two registers. By hand: libmodbus 3.1.6 packs floats wrongly and 3.1.8
// differently.
std::array<std::uint16_t, 2> pack_float(float value, WordOrder order);
float unpack_float(std::span<const std::uint16_t, 2> registers, WordOrder order);

double degc_from_wire(float value, Unit unit);
float wire_from_degc(double degc, Unit unit);
double kelvin_from_wire(float value, Unit unit);  // of a difference, such as a band
float wire_from_kelvin(double kelvin, Unit unit);

// What a PM near room temperature can mean: a wrong word order or unit falls outside.
inline constexpr double kPlausibleMinDegc = 5.0, kPlausibleMaxDegc = 60.0;
bool is_plausible(double degc);  // false for NaN

std::string describe_input_error(std::uint16_t code);  // "65 (open)"
std::string describe_unit(std::uint16_t code);         // "30 (F)"

using driftwise::symbol_from_id;

}  // namespace driftwise::watlow
