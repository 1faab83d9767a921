#pragma once
// A channel is one named quantity with a unit: "t07_degC" is symbol "t07" in unit "degC".
// The full name stands in files, the database and messages; formulas use the symbol.

#include <string>
#include <string_view>
#include <vector>

#include "server/core/result.h"

namespace driftwise {

struct Channel {
  std::string symbol;  // "t07", "q1", "x", "x_std"
  std::string unit;    // "degC", "mm", "nm", "1" for none

  std::string name() const { return symbol + "_" + unit; }
  bool operator==(const Channel&) const = default;
};

// Splits at the last '_' and checks the unit against units(). A symbol is a letter, then letters,
// digits, '_'. Errors: invalid_argument, reason BAD_CHANNEL, naming the text and the units allowed.
Result<Channel> parse_channel(std::string_view name);

// The same, or with a robot's id and a dot before it, as in cells with several robots: "ma.q1_mm".
Result<Channel> parse_robot_channel(std::string_view name);
// "ma" of "ma.q1"; empty: the symbol carries no robot's id.
std::string_view robot_of(std::string_view symbol);
// "q1" of "ma.q1" and of "q1".
std::string_view without_robot(std::string_view symbol);

// m mm um nm rad deg arcsec degC K N Pa hPa pct V A W Hz rpm s 1
const std::vector<std::string>& known_units();

bool is_length(std::string_view unit);  // m mm um nm
bool is_angle(std::string_view unit);   // rad deg arcsec

// How results are summarised: lengths in nm, angles in arcsec, anything else in its own unit.
struct SummaryUnit {
  std::string unit;  // "nm"
  double factor;     // value_in_summary = factor * value_in_unit
};
SummaryUnit summary_unit(std::string_view unit);

// q1, q2, ... (motor coordinates as read back), x y z rx ry rz (pose), tNN (structure temperature).
bool is_motor_symbol(std::string_view symbol);
bool is_pose_symbol(std::string_view symbol);
// Light that an optical instrument gets back, by its full name: a share in pct whose symbol has the
// word "level", as in level_pct, level_y_pct or level_ma_x_pct.
bool is_light_level(std::string_view name);
// A temperature that may stand for the structure: degC or K, not air, not a set-point or a spread.
bool is_structure_temperature(const Channel& channel);

}  // namespace driftwise
