#include "server/core/records/wanted_accuracy.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>

#include "server/core/channel.h"
#include "server/core/reasons.h"
#include "server/core/text/shown_text.h"

namespace driftwise {
namespace {

constexpr std::string_view kOfUnit = "wanted_a90_", kOfCoordinate = "wanted_a90.";

Error bad_wanted(const MetadataItem& item, const std::string& expected) {
  return {ErrorCode::invalid_argument, reasons::kBadMetadata,
          "metadata: found " + shown(item.key + "=" + item.value) + ", expected " + expected};
}

}  // namespace

bool states_wanted_accuracy(std::string_view key) {
  return key.starts_with(kOfUnit) || key.starts_with(kOfCoordinate);
}

Result<WantedAccuracy> wanted_accuracy_from(const MetadataItem& item) {
  double a90 = 0;
  const char* last = item.value.data() + item.value.size();
  const auto [end, error] = std::from_chars(item.value.data(), last, a90);
  if (error != std::errc() || end != last || !(a90 > 0) || a90 > 1e15)
    return tl::unexpected(bad_wanted(item, "a number above 0: " + item.key + "=100"));
  WantedAccuracy wanted;
  std::string unit;
  if (item.key.starts_with(kOfCoordinate)) {
    const auto channel = parse_robot_channel(item.key.substr(kOfCoordinate.size()));
    if (!channel || !is_pose_symbol(without_robot(channel->symbol)))
      return tl::unexpected(bad_wanted(item,
                                       "a coordinate of the pose and its unit: wanted_a90.x_nm, "
                                       "wanted_a90.rx_arcsec"));
    wanted.coordinate = channel->symbol;
    unit = channel->unit;
  } else {
    unit = item.key.substr(kOfUnit.size());
  }
  if (!is_length(unit) && !is_angle(unit))
    return tl::unexpected(bad_wanted(item, "a unit of length or angle: wanted_a90_nm"));
  const auto summary = summary_unit(unit);
  wanted.unit = summary.unit;
  wanted.a90 = a90 * summary.factor;
  return wanted;
}

void add_wanted(std::vector<WantedAccuracy>& wanted, WantedAccuracy one) {
  const auto same = std::ranges::find_if(wanted, [&](const WantedAccuracy& other) {
    return other.coordinate == one.coordinate && other.unit == one.unit;
  });
  if (same == wanted.end())
    wanted.push_back(std::move(one));
  else
    same->a90 = std::min(same->a90, one.a90);
}

const WantedAccuracy* wanted_of(std::span<const WantedAccuracy> wanted, std::string_view symbol,
                                std::string_view unit) {
  const WantedAccuracy *of_unit = nullptr, *smallest = nullptr;
  for (const auto& one : wanted) {
    if (one.unit != unit) continue;
    if (one.coordinate == symbol) return &one;
    if (one.coordinate.empty()) of_unit = &one;
    if (robot_of(one.coordinate) != robot_of(symbol)) continue;
    if (smallest == nullptr || one.a90 < smallest->a90) smallest = &one;
  }
  if (of_unit != nullptr || !is_motor_symbol(without_robot(symbol))) return of_unit;
  return smallest;
}

std::string wanted_text(std::span<const WantedAccuracy> wanted) {
  std::string text;
  for (const auto& one : wanted) {
    std::array<char, 32> figure{};
    std::snprintf(figure.data(), figure.size(), "%.6g", one.a90);
    const std::string of = !one.coordinate.empty() ? one.coordinate
                           : is_length(one.unit)   ? "every length"
                                                   : "every rotation";
    text += (text.empty() ? "" : ", ") + of + " " + figure.data() + " " + one.unit;
  }
  return text;
}

}  // namespace driftwise
