#include "server/formats/cell_file/cell_file_devices.h"

#include <algorithm>

#include "server/core/reasons.h"
#include "server/formats/cell_file/cell_file_address.h"
#include "server/formats/text/text.h"

namespace driftwise::formats {
namespace {

// The reader that a device kind is given: one table of the file, place by place.
class DeviceSettings final : public SettingsReader {
 public:
  DeviceSettings(TomlReader& toml, std::string place, TakenNames& taken, TomlProblem& problem)
      : toml_(toml), place_(std::move(place)), taken_(taken), problem_(problem) {}

  void text(const char* key, std::string& value, Need need) override {
    toml_.text(key, value, need);
  }
  void choice(const char* key, std::string& value, std::initializer_list<std::string_view> allowed,
              Need need) override {
    toml_.choice(key, value, allowed, need);
  }
  void number(const char* key, double& value, Range range, Need need) override {
    toml_.number(key, value, range, need);
  }
  void integer(const char* key, int& value, int min, int max, Need need) override {
    toml_.integer(key, value, min, max, need);
  }
  void channel(const char* key, Channel& value, Need need) override;
  void give(const char* key, const std::string& channel) override {
    taken_.channel(toml_, key, channel);
  }
  void each(const char* key, const std::function<void(SettingsReader&)>& read) override;
  void refuse(const char* key, Reason reason, const std::string& sentence) override {
    toml_.refuse(key, reason, sentence);
  }

 private:
  TomlReader& toml_;
  std::string place_;
  TakenNames& taken_;
  TomlProblem& problem_;
};

// With several robots a motor or pose channel carries the robot's id and a dot: ma.q1_mm.
void DeviceSettings::channel(const char* key, Channel& value, Need need) {
  if (taken_.robots.empty()) return toml_.channel(key, value, need);
  std::string name;
  toml_.text(key, name, need);
  if (name.empty()) return;
  const auto dot = name.find('.');
  const std::string robot = dot == std::string::npos ? "" : name.substr(0, dot);
  auto parsed = parse_channel(robot.empty() ? name : name.substr(dot + 1));
  if (!parsed) return toml_.refuse(key, reasons::kBadChannel, parsed.error().message);
  const bool is_robots = is_motor_symbol(parsed->symbol) || is_pose_symbol(parsed->symbol);
  if (is_robots && !taken_.robots.contains(robot)) {
    std::string ids;
    for (const auto& id : taken_.robots) ids += (ids.empty() ? "" : ", ") + id;
    return toml_.refuse(key, reasons::kBadChannel,
                        "found " + shown(name) +
                            ", expected the id of its robot and a dot before " + "it, such as " +
                            *taken_.robots.begin() + "." + parsed->name() + "; the robots are " +
                            ids);
  }
  if (!is_robots && !robot.empty())
    return toml_.refuse(key, reasons::kBadChannel,
                        "found " + shown(name) + ", expected " + parsed->name() +
                            ": it belongs to the cell, not to a robot");
  value = std::move(*parsed);
  if (!robot.empty()) value.symbol = robot + "." + value.symbol;
}

void DeviceSettings::each(const char* key, const std::function<void(SettingsReader&)>& read) {
  const auto tables = toml_.tables(key);
  int number = 0;
  for (const auto* table : tables) {
    const std::string place = place_ + ", " + key + " " + std::to_string(++number);
    TomlReader one(*table, place, problem_);
    DeviceSettings settings(one, place, taken_, problem_);
    read(settings);
    one.finish();
  }
  if (tables.empty())
    toml_.refuse(key, reasons::kMissingKey,
                 std::string("found nothing, expected at least one [[device.") + key + "]]");
}

}  // namespace

void TakenNames::channel(TomlReader& reader, const char* key, const std::string& name) {
  const auto [giver, is_new] = channels.try_emplace(name, device);
  if (is_new) return;
  const auto parsed = parse_channel(name.substr(name.find('.') + 1));
  const bool is_coordinate = parsed && is_pose_symbol(parsed->symbol);
  if (is_coordinate && has_setups && giver->second != device) return;
  reader.refuse(key, reasons::kDuplicateChannel,
                "found " + shown(name) + ", which another device, axis or probe gives already" +
                    (is_coordinate && !has_setups
                         ? ": only a cell with [[setup]] measures a coordinate with several "
                           "instruments, in runs of their own"
                         : ""));
}

void read_device(TomlReader&& reader, const std::string& place, DeviceKinds kinds,
                 DeviceDescription& out, TakenNames& taken, TomlProblem& problem) {
  reader.text("id", out.id, Need::required);
  taken.device = out.id;
  if (!taken.ids.insert(out.id).second)
    reader.refuse("id", reasons::kDuplicateId,
                  "found " + shown(out.id) + ", which another device has already");
  std::vector<std::string_view> names;
  for (const auto* kind : kinds) names.push_back(kind->id);
  reader.choice("kind", out.kind, names, Need::required);
  reader.text("address", out.address, Need::required);
  check_device_address(reader, out.address);
  reader.text("identity", out.identity);
  reader.number("timeout_s", out.timeout_s, {.min = 0, .max = 3600, .above_min = true});
  reader.number("period_s", out.period_s, {.min = 0, .max = 86400});
  reader.number("max_age_s", out.max_age_s, {.min = 0, .above_min = true});
  reader.strings("options", out.options);
  const auto* kind = find_kind(kinds, out.kind);
  if (problem.any() || kind == nullptr) return;  // without a kind the rest cannot be judged

  out.settings = settings_for(kind->role);
  DeviceSettings settings(reader, place, taken, problem);
  kind->read_settings(settings, out);
  out.channels = kind->channels(out);
  reader.finish();
}

}  // namespace driftwise::formats
