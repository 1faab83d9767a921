#include "drivers/simulated/emulators/cell/emulator_options.h"

#include <toml++/toml.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <sstream>

namespace driftwise::simulated {
namespace {

struct Setting {
  std::string section, name, value, place;
};

std::string value_text(const toml::node& node, const std::string& place) {
  if (const auto* text = node.as_string()) return text->get();
  if (const auto* flag = node.as_boolean()) return flag->get() ? "true" : "false";
  std::ostringstream out;
  if (const auto* whole = node.as_integer())
    out << whole->get();
  else if (const auto* number = node.as_floating_point())
    out << number->get();
  else
    throw SetupError(place + ": expected a text, a number, true or false");
  return out.str();
}

std::vector<Setting> settings_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw SetupError(file.string() + ": cannot be read");
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  toml::table root;
  try {
    root = toml::parse(text, file.string());
  } catch (const toml::parse_error& error) {
    throw SetupError(file.string() + ":" + std::to_string(error.source().begin.line) +
                     ": not TOML: " + std::string(error.description()));
  }
  std::vector<Setting> out;
  const auto take = [&](const std::string& section, const toml::node& node) {
    const toml::table* table = node.as_table();
    const std::string place =
        file.string() + ":" + std::to_string(node.source().begin.line) + ": " + section;
    if (table == nullptr) throw SetupError(place + ": expected a table");
    for (const auto& [key, value] : *table) {
      const std::string name(key.str());
      const std::string at = file.string() + ":" + std::to_string(value.source().begin.line) +
                             ": " + section + "." + name;
      out.push_back({section, name, value_text(value, at), at});
    }
  };
  if (const toml::node* emulator = root.get("emulator")) {
    if (!emulator->is_table())
      throw SetupError(file.string() + ": emulator: expected tables such as [emulator.pi]");
    for (const auto& [key, value] : *emulator->as_table())
      take("emulator." + std::string(key.str()), value);
  }
  if (const toml::node* wire = root.get("wire")) take("wire", *wire);
  return out;
}

}  // namespace

const std::vector<SwitchDescription>& wire_switches() {
  static const std::vector<SwitchDescription> kAll{
      {"chop", "true", "own", "replies arrive split and merged"},
      {"chop_share", "0.3", "own", "share of the writes that are split"},
      {"pause_us", "60", "own", "wall time between the pieces"},
  };
  return kAll;
}

EmulatorOptions::EmulatorOptions(const std::filesystem::path& plant_file,
                                 std::vector<std::string>& settings,
                                 const std::vector<DeviceOutline>& devices)
    : devices_(devices), wire_("[wire]", wire_switches()) {
  for (const auto& device : devices_) {
    const EmulatorKind* kind = find_emulator_kind(device.kind);
    if (kind == nullptr)
      throw SetupError("device '" + device.id + "': there is no emulator for kind '" + device.kind +
                       "'");
    by_device_.emplace(device.id, Switches("[emulator." + device.id + "]", kind->switches()));
  }
  std::vector<Setting> all = settings_of(plant_file);
  for (const auto& text : settings) {
    if (!text.starts_with("emulator.") && !text.starts_with("wire.")) continue;
    const auto equals = text.find('=');
    const auto dot = text.rfind('.', equals);
    const std::string place = "--set " + text;
    if (equals == std::string::npos || dot == std::string::npos ||
        text.find('.') == std::string::npos)
      throw SetupError(place +
                       ": expected emulator.<device>.<switch>=value or wire.<switch>=value");
    all.push_back({text.substr(0, dot), text.substr(dot + 1, equals - dot - 1),
                   text.substr(equals + 1), place});
  }
  std::erase_if(settings, [](const std::string& text) {
    return text.starts_with("emulator.") || text.starts_with("wire.");
  });
  for (const bool by_id : {false, true})
    for (const auto& one : all) set(one.section, one.name, one.value, one.place, by_id);
}

void EmulatorOptions::set(const std::string& section, const std::string& name,
                          const std::string& value, const std::string& place, bool by_id) {
  const auto apply = [&](Switches& switches) {
    try {
      switches.set(name, value);
    } catch (const SetupError& error) {
      throw SetupError(place + ": " + error.what());
    }
  };
  if (section == "wire") {
    apply(wire_);
    return;
  }
  const std::string target =
      section.substr(std::min(section.size(), std::string("emulator.").size()));
  bool known = false;
  for (const auto& kind : emulator_kinds()) {
    if (kind.section != target) continue;
    known = true;
    for (const auto& device : devices_)
      if (!by_id && device.kind == kind.kind) apply(by_device_.at(device.id));
  }
  if (const auto device = by_device_.find(target); device != by_device_.end()) {
    // A device may be called like a kind ("scanner"): then the section means the kind, which
    // includes it.
    if (by_id && !known) apply(device->second);
    known = true;
  }
  if (!known) {
    std::string names;
    for (const auto& kind : emulator_kinds())
      names += (names.empty() ? "" : ", ") + std::string(kind.section);
    for (const auto& device : devices_) names += ", " + device.id;
    throw SetupError(place + ": there is no emulator '" + target + "'; there are " + names);
  }
}

WireOptions EmulatorOptions::wire(std::uint64_t seed) const {
  return {.chop = wire_.flag("chop"),
          .chop_share = wire_.number("chop_share", 0, 1),
          .pause = std::chrono::microseconds(wire_.integer("pause_us", 0, 1000000)),
          .seed = seed};
}

}  // namespace driftwise::simulated
