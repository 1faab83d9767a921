#include "server/formats/cell_file/cell_file_setups.h"

#include <algorithm>

#include "server/core/reasons.h"
#include "server/formats/text/text.h"

namespace driftwise::formats {
namespace {

// Coordinates that an instrument gives.
std::vector<Channel> coordinates_of(const DeviceDescription& device) {
  std::vector<Channel> out;
  if (const auto* length = device.length()) out.push_back(length->channel);
  for (const auto& angle : device.angles()) out.push_back(angle.channel);
  return out;
}

std::string list_of_coordinates(const std::vector<Channel>& channels) {
  std::string list;
  for (const auto& channel : channels) list += (list.empty() ? "" : ", ") + channel.name();
  return list.empty() ? "none" : list;
}

std::string ids_of_instruments(const CellDescription& cell) {
  std::string list;
  for (const auto& device : cell.devices)
    if (measures_pose(device.role())) list += (list.empty() ? "" : ", ") + device.id;
  return list.empty() ? "none" : list;
}

void check_device(TomlReader& reader, const SetupCoordinate& coordinate,
                  const CellDescription& cell) {
  const auto* device = cell.find_device(coordinate.device);
  if (device == nullptr || !measures_pose(device->role()))
    return reader.refuse("device", reasons::kBadSetup,
                         "found " + shown(coordinate.device) +
                             ", expected an interferometer or autocollimator of this cell: " +
                             ids_of_instruments(cell));
  const auto given = coordinates_of(*device);
  if (std::ranges::find(given, coordinate.channel) == given.end())
    reader.refuse("channel", reasons::kBadSetup,
                  "found " + shown(coordinate.channel.name()) + ", expected a coordinate of " +
                      shown(device->id) + ": " + list_of_coordinates(given));
}

// The same for an instrument that confirms.
void read_confirmation(TomlReader&& reader, const CellDescription& cell, SetupDescription& setup) {
  SetupConfirmation one;
  reader.robot_channel("channel", one.channel, Need::required);
  reader.text("device", one.device, Need::required);
  reader.number("scale", one.scale, {.min = -1e6, .max = 1e6});
  reader.number("offset", one.offset, {.min = -1e6, .max = 1e6});
  reader.number("limit", one.limit, {.min = 0, .max = 1e9, .above_min = true}, Need::required);
  if (one.scale == 0)
    reader.refuse("scale", reasons::kBadSetup, "found 0, expected another number");
  const auto measured =
      std::ranges::find(setup.coordinates, one.channel, &SetupCoordinate::channel);
  if (!one.channel.symbol.empty() && measured == setup.coordinates.end())
    reader.refuse("channel", reasons::kBadSetup,
                  "found " + shown(one.channel.name()) +
                      ", expected a coordinate that this set-up measures with another instrument");
  else if (!one.channel.symbol.empty() && !is_angle(one.channel.unit))
    reader.refuse("channel", reasons::kBadSetup,
                  "found " + shown(one.channel.name()) +
                      ", expected a rotation: a length is confirmed by a run in another set-up");
  else if (!one.device.empty() && !one.channel.symbol.empty()) {
    check_device(reader, {one.channel, one.device, 1, 0, {}, {}}, cell);
    if (measured->device == one.device)
      reader.refuse("device", reasons::kBadSetup,
                    "found " + shown(one.device) +
                        ", which measures this coordinate, expected a second instrument");
  }
  if (std::ranges::find(setup.confirmations, one.channel, &SetupConfirmation::channel) !=
      setup.confirmations.end())
    reader.refuse("channel", reasons::kDuplicateChannel,
                  "found " + shown(one.channel.name()) +
                      ", which another confirmation of this set-up has already");
  reader.finish();
  setup.confirmations.push_back(std::move(one));
}

// A length reads 0 at the zero, where every return is compared with the one before. A range without
// that place has no return to compare. Rotations count from wherever their instrument stands.
void check_zero_is_inside(TomlReader& reader, const SetupCoordinate& coordinate) {
  if (coordinate.channel.symbol.empty() || is_angle(coordinate.channel.unit)) return;
  const double at_zero = coordinate.offset;  // scale * 0 + offset
  const char* key = coordinate.min && at_zero < *coordinate.min   ? "min"
                    : coordinate.max && at_zero > *coordinate.max ? "max"
                                                                  : nullptr;
  if (key == nullptr) return;
  const std::string& unit = coordinate.channel.unit;
  reader.refuse(key, reasons::kBadSetup,
                "found " + number_text(key[1] == 'i' ? *coordinate.min : *coordinate.max) + " " +
                    unit + ", which leaves out the zero of " + shown(coordinate.channel.name()) +
                    " (" + number_text(at_zero) + " " + unit +
                    " after scale and offset), expected a range with it: at the zero the length " +
                    "must be measured, or no return is compared");
}

void read_coordinate(TomlReader&& reader, const CellDescription& cell, SetupDescription& setup) {
  SetupCoordinate coordinate;
  reader.robot_channel("channel", coordinate.channel, Need::required);
  reader.text("device", coordinate.device, Need::required);
  reader.number("scale", coordinate.scale, {.min = -1e6, .max = 1e6});
  reader.number("offset", coordinate.offset, {.min = -1e6, .max = 1e6});
  double limit = 0;
  reader.number("min", limit, {.min = -1e9, .max = 1e9});
  if (reader.has("min")) coordinate.min = limit;
  reader.number("max", limit, {.min = -1e9, .max = 1e9});
  if (reader.has("max")) coordinate.max = limit;
  if (!coordinate.device.empty() && !coordinate.channel.symbol.empty())
    check_device(reader, coordinate, cell);
  if (coordinate.scale == 0)
    reader.refuse("scale", reasons::kBadSetup, "found 0, expected another number");
  if (coordinate.min && coordinate.max && !(*coordinate.min < *coordinate.max))
    reader.refuse("min", reasons::kBadSetup,
                  "found min = " + number_text(*coordinate.min) + " and max = " +
                      number_text(*coordinate.max) + ", expected min to be the lower one");
  check_zero_is_inside(reader, coordinate);
  if (std::ranges::find(setup.coordinates, coordinate.channel, &SetupCoordinate::channel) !=
      setup.coordinates.end())
    reader.refuse("channel", reasons::kDuplicateChannel,
                  "found " + shown(coordinate.channel.name()) +
                      ", which another coordinate of this set-up has already");
  reader.finish();
  setup.coordinates.push_back(std::move(coordinate));
}

bool is_confirmed_by(const SetupDescription& setup, const Channel& channel,
                     const std::string& device) {
  return std::ranges::any_of(setup.confirmations, [&](const SetupConfirmation& one) {
    return one.channel == channel && one.device == device;
  });
}

// What a confirming instrument gives besides is neither measured by it nor left unsaid.
void check_confirming(TomlReader& reader, const SetupDescription& setup,
                      const CellDescription& cell) {
  for (const auto& one : setup.confirmations) {
    const auto* device = cell.find_device(one.device);
    if (device == nullptr) continue;
    for (const auto& channel : coordinates_of(*device)) {
      const auto measured =
          std::ranges::find(setup.coordinates, channel, &SetupCoordinate::channel);
      if (measured == setup.coordinates.end() || measured->device == one.device ||
          is_confirmed_by(setup, channel, one.device))
        continue;
      return reader.refuse("confirmation", reasons::kBadSetup,
                           "found " + shown(one.device) + " for " + shown(one.channel.name()) +
                               ", which gives " + shown(channel.name()) + " as " +
                               shown(measured->device) +
                               " does, expected a [[setup.confirmation]] of it too");
    }
  }
}

// An instrument that the set-up names for one coordinate gives its others as well.
void check_given_once(TomlReader& reader, const SetupDescription& setup,
                      const CellDescription& cell) {
  for (const auto& coordinate : setup.coordinates)
    for (const auto& other : setup.coordinates) {
      const auto* device = cell.find_device(other.device);
      if (device == nullptr || other.device == coordinate.device) continue;
      const auto given = coordinates_of(*device);
      if (std::ranges::find(given, coordinate.channel) == given.end()) continue;
      if (is_confirmed_by(setup, coordinate.channel, other.device)) continue;
      return reader.refuse(
          "coordinate", reasons::kBadSetup,
          "found " + shown(coordinate.channel.name()) + " of " + shown(coordinate.device) +
              ", and " + shown(other.device) +
              " gives it as well, expected instruments of which one gives it, or a " +
              "[[setup.confirmation]] of it by the second one");
    }
}

}  // namespace

void read_setup(TomlReader&& reader, const std::string& place, CellDescription& out,
                TomlProblem& problem) {
  SetupDescription setup;
  reader.text("name", setup.name, Need::required);
  reader.text("description", setup.description);
  for (const auto* table : reader.tables("coordinate"))
    read_coordinate(
        TomlReader(*table, place + ", coordinate " + std::to_string(setup.coordinates.size() + 1),
                   problem),
        out, setup);
  for (const auto* table : reader.tables("confirmation"))
    read_confirmation(
        TomlReader(*table,
                   place + ", confirmation " + std::to_string(setup.confirmations.size() + 1),
                   problem),
        out, setup);
  if (setup.coordinates.empty())
    reader.refuse("coordinate", reasons::kBadSetup,
                  "found no [[setup.coordinate]], expected one at least: what it measures");
  check_given_once(reader, setup, out);
  check_confirming(reader, setup, out);
  if (std::ranges::find(out.setups, setup.name, &SetupDescription::name) != out.setups.end())
    reader.refuse("name", reasons::kDuplicateId,
                  "found " + shown(setup.name) + ", which another [[setup]] has already");
  reader.finish();
  out.setups.push_back(std::move(setup));
}

}  // namespace driftwise::formats
