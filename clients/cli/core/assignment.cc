#include "clients/cli/core/assignment.h"

#include <map>
#include <optional>

#include "clients/cli/core/console.h"
#include "clients/cli/core/text.h"
#include "server/core/channel.h"

namespace driftwise::cli {
namespace {

// Of a robot of several: ma.rx.
std::optional<std::string> unit_of(const std::string& full) {
  const std::string symbol(without_robot(full));
  if (full.size() == symbol.size() + 1) return std::nullopt;
  if (is_motor_symbol(symbol)) return "mm";
  if (symbol == "force" || symbol == "F") return "N";
  if (!is_pose_symbol(symbol)) return std::nullopt;
  return symbol.size() == 2 ? "arcsec" : "mm";
}

}  // namespace

v1::ChannelValue assignment_from(const std::string& text) {
  const auto bad = [&text](const std::string& why) {
    return Failure{
        ExitCode::usage, "invalid_argument", "BAD_ASSIGNMENT",
        "found '" + text + "', " + why +
            "; expected something like x=1.5 (mm), ry=12 (arcsec), force=0.3 (N), or ma.z=3 of a "
            "robot of several"};
  };
  const auto equals = text.find('=');
  if (equals == std::string::npos) throw bad("which assigns nothing");
  std::string name = text.substr(0, equals), number = text.substr(equals + 1);
  const auto dot = name.find('.');
  std::string symbol = name.substr(0, name.find('_', dot == std::string::npos ? 0 : dot));
  auto unit = unit_of(symbol);
  if (!unit) throw bad("'" + name + "' is no coordinate");
  // A joint of an arm; a rotation in degrees.
  for (const char* angle : {"rad", "deg"})
    if (is_motor_symbol(without_robot(symbol)) && name == symbol + "_" + angle) unit = angle;
  const bool degrees = *unit == "arcsec" && name == symbol + "_deg";
  if (degrees) name = symbol;
  if (name != symbol && name != symbol + "_" + *unit)
    throw bad("'" + symbol + "' is given in " + *unit);
  if (number.ends_with(*unit)) number.resize(number.size() - unit->size());
  while (number.ends_with(' ')) number.pop_back();
  const auto value = number_from(number);
  if (!value) throw bad("'" + text.substr(equals + 1) + "' is not a finite number of " + *unit);
  v1::ChannelValue out;
  out.set_channel((symbol == "F" ? "force" : symbol) + "_" + *unit);
  out.set_value(degrees ? *value * 3600 : *value);
  return out;
}

google::protobuf::RepeatedPtrField<v1::ChannelValue> assignments_from(
    const std::vector<std::string>& texts) {
  google::protobuf::RepeatedPtrField<v1::ChannelValue> out;
  std::map<std::string, std::string> given;  // texts by symbol: q1_deg and q1_rad are one
  for (const auto& text : texts) {
    auto& added = *out.Add() = assignment_from(text);
    const auto symbol = added.channel().substr(0, added.channel().rfind('_'));
    const auto [at, first] = given.emplace(symbol, text);
    if (!first)
      throw Failure{ExitCode::usage, "invalid_argument", "BAD_ASSIGNMENT",
                    "found '" + at->second + "' and '" + text + "', expected " + symbol + " once"};
  }
  return out;
}

}  // namespace driftwise::cli
