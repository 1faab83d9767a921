#include "server/core/channel.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <numbers>

#include "server/core/reasons.h"
#include "server/core/text/clean_text.h"

namespace driftwise {
namespace {

bool is_symbol(std::string_view text) {
  if (text.empty() || !std::isalpha(static_cast<unsigned char>(text.front()))) return false;
  return std::ranges::all_of(text, [](unsigned char c) { return std::isalnum(c) || c == '_'; });
}

bool all_digits(std::string_view text) {
  return !text.empty() &&
         std::ranges::all_of(text, [](unsigned char c) { return std::isdigit(c) != 0; });
}

}  // namespace

const std::vector<std::string>& known_units() {
  static const std::vector<std::string> units = {"m",    "mm", "um", "nm",  "rad", "deg", "arcsec",
                                                 "degC", "K",  "N",  "Pa",  "hPa", "pct", "V",
                                                 "A",    "W",  "Hz", "rpm", "s",   "1"};
  return units;
}

Result<Channel> parse_channel(std::string_view name) {
  const std::size_t cut = name.rfind('_');
  if (cut != std::string_view::npos) {
    const std::string_view symbol = name.substr(0, cut);
    const std::string_view unit = name.substr(cut + 1);
    const auto& units = known_units();
    if (is_symbol(symbol) && std::ranges::find(units, unit) != units.end())
      return Channel{std::string(symbol), std::string(unit)};
  }
  std::string allowed;
  for (const auto& unit : known_units()) allowed += (allowed.empty() ? "" : " ") + unit;
  return fail(ErrorCode::invalid_argument, reasons::kBadChannel,
              "'" + clean_line(name.substr(0, 64)) + (name.size() > 64 ? "..." : "") +
                  "' is no channel: expected <name>_<unit> such as t07_degC, unit one of " +
                  allowed);
}

Result<Channel> parse_robot_channel(std::string_view name) {
  const std::size_t dot = name.find('.');
  if (dot == std::string_view::npos || !is_symbol(name.substr(0, dot))) return parse_channel(name);
  auto channel = parse_channel(name.substr(dot + 1));
  if (!channel) return channel;
  const std::string_view symbol = channel->symbol;
  const std::string_view stem = symbol.substr(0, symbol.find('_'));  // x of x_std
  if (!is_motor_symbol(stem) && !is_pose_symbol(stem)) return parse_channel(name);
  channel->symbol.insert(0, name.substr(0, dot + 1));
  return channel;
}

std::string_view robot_of(std::string_view symbol) {
  const std::size_t dot = symbol.find('.');
  return dot == std::string_view::npos ? std::string_view() : symbol.substr(0, dot);
}

std::string_view without_robot(std::string_view symbol) {
  const std::size_t dot = symbol.find('.');
  return dot == std::string_view::npos ? symbol : symbol.substr(dot + 1);
}

bool is_length(std::string_view unit) {
  return unit == "m" || unit == "mm" || unit == "um" || unit == "nm";
}

bool is_angle(std::string_view unit) { return unit == "rad" || unit == "deg" || unit == "arcsec"; }

SummaryUnit summary_unit(std::string_view unit) {
  if (unit == "m") return {"nm", 1e9};
  if (unit == "mm") return {"nm", 1e6};
  if (unit == "um") return {"nm", 1e3};
  if (unit == "nm") return {"nm", 1.0};
  if (unit == "rad") return {"arcsec", 180.0 * 3600.0 / std::numbers::pi};
  if (unit == "deg") return {"arcsec", 3600.0};
  return {std::string(unit), 1.0};
}

bool is_motor_symbol(std::string_view symbol) {
  return symbol.size() >= 2 && symbol.front() == 'q' && all_digits(symbol.substr(1));
}

bool is_pose_symbol(std::string_view symbol) {
  static constexpr std::array<std::string_view, 6> pose = {"x", "y", "z", "rx", "ry", "rz"};
  return std::ranges::find(pose, symbol) != pose.end();
}

bool is_light_level(std::string_view name) {
  constexpr std::string_view kUnit = "_pct";
  if (!name.ends_with(kUnit)) return false;
  const auto symbol = without_robot(name.substr(0, name.size() - kUnit.size()));
  return ("_" + std::string(symbol) + "_").find("_level_") != std::string::npos;
}

bool is_structure_temperature(const Channel& channel) {
  const std::string& symbol = channel.symbol;
  return (channel.unit == "degC" || channel.unit == "K") && !symbol.starts_with("air") &&
         !symbol.ends_with("_set") && !symbol.ends_with("_cmd") && !symbol.ends_with("_std");
}

}  // namespace driftwise
