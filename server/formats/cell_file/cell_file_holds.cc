#include "server/formats/cell_file/cell_file_holds.h"

#include <algorithm>

#include "server/core/reasons.h"
#include "server/formats/text/text.h"

namespace driftwise::formats {

std::vector<std::string> channels_read(const CellDescription& cell) {
  std::vector<std::string> names;
  for (const auto& channel : cell.length_channels()) names.push_back(channel.name());
  for (const auto& channel : cell.path_channels()) names.push_back(channel.name());
  if (const auto force = cell.force_channel()) names.push_back(force->name());
  for (const auto& device : cell.devices) {
    for (const auto& channel : device.channels) names.push_back(channel.name());
  }
  std::ranges::sort(names);
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

void check_is_read(TomlReader& reader, const char* key, const std::string& channel,
                   const std::vector<std::string>& names) {
  if (channel.empty() || std::ranges::binary_search(names, channel)) return;
  std::string known;
  for (const auto& name : names) known += (known.empty() ? "" : ", ") + name;
  reader.refuse(key, reasons::kNoSuchChannel,
                "found " + shown(channel) + ", expected a channel of this cell: " + known);
}

namespace {

void read_limit_of_hold(TomlReader& reader, const char* key, std::optional<double>& value) {
  double number = 0;
  reader.number(key, number);
  if (reader.has(key)) value = number;
}

void check_order(TomlReader& reader, const HoldRule& rule) {
  if (!rule.above && !rule.below)
    return reader.refuse("above", reasons::kMissingKey,
                         "found neither above nor below, expected a limit");
  if (rule.above && rule.below && !(*rule.below < *rule.above))
    return reader.refuse("below", reasons::kBadLimits,
                         "found below = " + number_text(*rule.below) + " and above = " +
                             number_text(*rule.above) + ", expected below to be the lower one");
  const auto outside = [&](const char* key, const std::optional<double>& release,
                           const std::optional<double>& limit, bool is_beyond) {
    if (!release || (limit && !is_beyond)) return;
    reader.refuse(key, reasons::kBadLimits,
                  "found " + number_text(*release) +
                      ", expected a limit within the one that holds: the hold would end while it "
                      "is exceeded");
  };
  outside("release_above", rule.release_above, rule.above,
          rule.above && *rule.release_above > *rule.above);
  outside("release_below", rule.release_below, rule.below,
          rule.below && *rule.release_below < *rule.below);
}

}  // namespace

void read_hold(TomlReader&& reader, CellDescription& out) {
  HoldRule rule;
  auto names = channels_read(out);
  names.insert(std::ranges::upper_bound(names, HoldRule::kDiskFreeGb), HoldRule::kDiskFreeGb);
  reader.text("name", rule.name, Need::required);
  reader.text("channel", rule.channel, Need::required);
  reader.text("minus", rule.minus);
  check_is_read(reader, "channel", rule.channel, names);
  check_is_read(reader, "minus", rule.minus, names);
  read_limit_of_hold(reader, "above", rule.above);
  read_limit_of_hold(reader, "below", rule.below);
  read_limit_of_hold(reader, "release_above", rule.release_above);
  read_limit_of_hold(reader, "release_below", rule.release_below);
  check_order(reader, rule);
  reader.number("for_s", rule.for_s, {.min = 0, .max = 1e6});
  reader.number("settle_s", rule.settle_s, {.min = 0, .max = 1e6});
  double stale_s = 0;
  reader.number("stale_s", stale_s, {.min = 0, .max = 1e6, .above_min = true});
  if (reader.has("stale_s")) rule.stale_s = stale_s;
  std::string action = "finish-point";
  reader.choice("action", action, {"finish-point", "return-to-zero", "stop", "end-daemon"},
                Need::optional);
  if (action == "return-to-zero") rule.action = HoldAction::return_to_zero;
  if (action == "stop") rule.action = HoldAction::stop;
  if (action == "end-daemon") rule.action = HoldAction::end_daemon;
  reader.truth("marks", rule.marks);
  reader.text("advice", rule.advice);
  if (std::ranges::find(out.holds, rule.name, &HoldRule::name) != out.holds.end())
    reader.refuse("name", reasons::kDuplicateId,
                  "found " + shown(rule.name) + ", which another [[hold]] has already");
  reader.finish();
  out.holds.push_back(std::move(rule));
}

void add_holds_of_stabilisers(CellDescription& out) {
  for (const auto& device : out.devices) {
    if (device.role() != DeviceRole::stabiliser) continue;
    HoldRule rule;
    rule.name = "stabiliser-" + device.id;
    if (std::ranges::find(out.holds, rule.name, &HoldRule::name) != out.holds.end()) continue;
    const std::string stem = symbol_from_id(device.id);
    rule.channel = stem + "_degC";
    rule.minus = stem + "_set_degC";
    rule.above = out.checks.stabiliser_band_k;
    rule.below = -out.checks.stabiliser_band_k;
    rule.for_s = 30;
    rule.settle_s = 120;
    rule.only_while_measuring = true;  // the start waits for it by itself: start_checks.h
    rule.advice = "look at its power and its sensor";
    out.holds.push_back(std::move(rule));
  }
}

}  // namespace driftwise::formats
