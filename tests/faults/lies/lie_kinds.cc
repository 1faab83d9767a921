#include "tests/faults/lies/lie_kinds.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "server/plausibility/limits.h"

namespace driftwise::lies {
namespace {

std::string option(const DeviceDescription& device, const char* name, const char* otherwise) {
  const auto found = device.options.find(name);
  return found == device.options.end() ? otherwise : found->second;
}

// The farthest that an axis goes in the lines of the table, and a length that no axis has to
// itself.
constexpr double kFarthest_mm = 2.0, kFarthestOfSeveral_mm = 1.0;

double farthest_mm(const CellDescription& cell) {
  return cell.motor_channels().size() > 1 ? kFarthestOfSeveral_mm : kFarthest_mm;
}

// The time between two answers of the channel in the lines of the table.
double longest_between_s(const CellDescription& cell, const ChannelOfCell& channel) {
  constexpr double kPoint_s = 12, kScan_s = 5;
  const double period_s = cell.find_device(channel.device)->period_s;
  return period_s > 0 ? period_s + kScan_s : kPoint_s;
}

double to_other_unit(const ChannelOfCell& channel, double value) {
  switch (channel.what) {
    case What::motor:
    case What::length:
      return 1000 * value;  // mm -> um
    case What::angle:
      return 4.8481368 * value;  // arcsec -> urad
    case What::part:
    case What::air:
    case What::support:
    case What::set_point:
      return 32 + 1.8 * value;  // degC -> degF
    case What::share:
      return value / 100;  // percent -> 1
    case What::force:
      return value / 9.81e-3;  // N -> g
  }
  return value;
}

}  // namespace

std::string name_of(Kind kind) {
  static const std::array<const char*, kKinds.size()> kNames = {
      "constant", "inverted", "jump", "scale", "unit",        "late",
      "other's",  "nan",      "inf",  "1e308", "out of range"};
  return kNames[static_cast<std::size_t>(kind)];
}

bool has_size(Kind kind) { return kind == Kind::jump || kind == Kind::scale || kind == Kind::late; }

bool is_impossible(Kind kind) {
  return kind == Kind::nan || kind == Kind::inf || kind == Kind::huge || kind == Kind::out_of_range;
}

std::vector<ChannelOfCell> channels_of(const CellDescription& cell) {
  std::vector<ChannelOfCell> all;
  for (const auto& device : cell.devices) {
    const auto add = [&](std::string name, What what) {
      all.push_back({std::move(name), device.id, what, {}});
    };
    for (const auto& axis : device.axes()) add(axis.channel.name(), What::motor);
    for (const auto& probe : device.probes())
      add(probe.channel.name(), probe.part == "air" ? What::air : What::part);
    for (const auto& angle : device.angles()) add(angle.channel.name(), What::angle);
    if (device.length()) {
      add(device.length()->channel.name(), What::length);
      add(option(device, "air_channel", "air_degC"), What::air);
      add(option(device, "level_channel", "level_pct"), What::share);
    }
    if (device.force()) add(device.force()->name(), What::force);
    if (device.kind == "watlow-ez-zone") {
      std::string stem = device.id;
      std::ranges::replace(stem, '-', '_');
      add(stem + "_degC", What::support);
      add(stem + "_set_degC", What::set_point);
      add(stem + "_power_pct", What::share);
    }
  }
  for (auto& one : all)
    for (const auto& other : all)
      if (&other != &one && other.what == one.what && one.other.empty()) one.other = other.name;
  return all;
}

bool takes_answers(const ChannelOfCell& channel, Kind kind) {
  return kind == Kind::constant && channel.what != What::motor && channel.what != What::length;
}

std::optional<double> expected_size(const CellDescription& cell, const ChannelOfCell& channel,
                                    Kind kind, double value) {
  const auto limit = plausibility::limit_of(cell, *cell.find_device(channel.device), channel.name);
  const auto& rules = cell.plausibility;
  const double per_min = rules.closure_nm_per_min.value_or(cell.checks.max_drift_nm_per_min);
  if (kind == Kind::late) {
    // A length that is later than the settling shows the place before.
    if (channel.what == What::length) return 4 + cell.run.settle_s;
    if (channel.what == What::motor) return cell.run.move_timeout_s + 5;
    return std::nullopt;
  }
  double jump = 0;
  switch (channel.what) {
    case What::motor:
      jump = 1e-6 * cell.run.in_position_nm;
      break;
    case What::length:
      if (kind == Kind::scale)
        return (1e-3 * rules.geometry_um + rules.geometry_pct / 100 * kFarthest_mm) /
               farthest_mm(cell);
      jump = 1e-6 * (rules.closure_nm + 1.5 * per_min);
      break;
    case What::angle:
      jump = rules.closure_arcsec;
      break;
    case What::part:
    case What::air:
    case What::support:
    case What::force:
      jump = limit.max_step + limit.max_per_s * longest_between_s(cell, channel);
      break;
    case What::set_point:
    case What::share:
      jump = limit.max - value;
      break;
  }
  if (kind == Kind::jump) return jump;
  if (channel.what == What::motor) return jump / kFarthest_mm;
  if (std::abs(value) < 1e-9) return std::nullopt;
  return jump / std::abs(value);
}

std::string why_not(const tests::PlantWorld& world, const CellDescription& cell,
                    const ChannelOfCell& channel, Kind kind) {
  const bool slow =
      channel.what != What::motor && channel.what != What::length && channel.what != What::angle;
  if (kind == Kind::other && channel.other.empty())
    return "no other channel of this kind answers in the cell";
  const bool steps =
      channel.what == What::part || channel.what == What::air || channel.what == What::support;
  if (kind == Kind::other && steps) {
    const double apart = std::abs(world.liar.truth(channel.other) - world.liar.truth(channel.name));
    if (apart <= *expected_size(cell, channel, Kind::jump, 0))
      return "the two channels differ by less than a step that is possible";
  }
  if (kind == Kind::late && channel.what == What::angle)
    return "tilts of neighbouring points differ by less than closure_arcsec";
  if (kind == Kind::late && slow)
    return "the delay times the drift of the channel is far below what joins a point falsely; a "
           "late time stamp is the clock's matter";
  switch (channel.what) {
    case What::share:
      if (!is_impossible(kind)) return "any share of its range is possible; no fit uses it";
      break;
    case What::set_point:
      if (kind == Kind::constant || kind == Kind::other)
        return "a set-point is constant, and the same for all supports";
      break;
    case What::force:
      if (kind == Kind::constant || kind == Kind::scale || kind == Kind::inverted ||
          kind == Kind::unit)
        return "no force acts: the answer is the truth";
      break;
    case What::angle:
      if (kind == Kind::constant) return "";  // by its own noise
      break;
    default:
      break;
  }
  return "";
}

double tolerance(const ChannelOfCell& channel) {
  switch (channel.what) {
    case What::motor:
    case What::length:
      return 3e-4;
    case What::angle:
      return 1.0;
    case What::part:
      return 0.05;
    case What::air:
    case What::support:
      return 0.5;
    case What::force:
      return 0.01;
    case What::set_point:
    case What::share:
      return 1.0;
  }
  return 0;
}

tests::Liar::Lie make_lie(const tests::PlantWorld& world, const CellDescription& cell,
                          const ChannelOfCell& channel, Kind kind, double size) {
  const auto limit = plausibility::limit_of(cell, *cell.find_device(channel.device), channel.name);
  const double held = world.liar.truth(channel.name);
  const auto* liar = &world.liar;
  switch (kind) {
    case Kind::constant:
      return [held](double, CellTime) { return held; };
    case Kind::inverted:
      return [](double value, CellTime) { return -value; };
    case Kind::jump:
      return [size](double value, CellTime) { return value + size; };
    case Kind::scale:
      return [size](double value, CellTime) { return value * (1 + size); };
    case Kind::unit:
      return [channel](double value, CellTime) { return to_other_unit(channel, value); };
    case Kind::late:
      return [liar, channel, size](double, CellTime at) {
        return liar->truth(channel.name, at - nanoseconds_from_s(size));
      };
    case Kind::other:
      return [liar, channel](double, CellTime) { return liar->truth(channel.other); };
    case Kind::nan:
      return [](double, CellTime) { return kMissing; };
    case Kind::inf:
      return [](double, CellTime) { return std::numeric_limits<double>::infinity(); };
    case Kind::huge:
      return [](double, CellTime) { return 1e308; };
    case Kind::out_of_range:
      return [limit](double, CellTime) { return limit.max + 0.1 * std::abs(limit.max) + 1; };
  }
  return {};
}

}  // namespace driftwise::lies
