#include "drivers/simulated/plant/file/plant_file.h"

#include <fstream>
#include <sstream>

#include "drivers/simulated/plant/file/make_plant.h"
#include "drivers/simulated/plant/file/plant_fields.h"
#include "drivers/simulated/plant/file/robot_sections.h"

namespace driftwise::simulated {
namespace {

// Key by key into a fresh table, so that the values carry no line number of the file.
bool put_value(toml::table& table, std::string_view key, const toml::node& node) {
  if (const auto* string = node.as_string()) {
    table.insert_or_assign(key, string->get());
  } else if (const auto* whole = node.as_integer()) {
    table.insert_or_assign(key, whole->get());
  } else if (const auto* number = node.as_floating_point()) {
    table.insert_or_assign(key, number->get());
  } else if (const auto* list = node.as_array()) {
    table.insert_or_assign(key, *list);
  } else {
    return false;
  }
  return true;
}

// [hidden] is in no file by default: an override may make its tables, also in one go:
// hidden.glue={kind="viscoelastic",...}.
void make_hidden(toml::table& root, std::string_view path) {
  toml::table* table = &root;
  for (auto dot = path.find('.'); dot != std::string_view::npos; dot = path.find('.')) {
    const std::string_view key = path.substr(0, dot);
    if (!table->contains(key)) table->insert(key, toml::table{});
    if (!table->get(key)->is_table()) return;
    table = table->get(key)->as_table();
    path.remove_prefix(dot + 1);
  }
  if (!table->contains(path)) table->insert(path, 0);
}

// A value is TOML (0.5, "steel", [1, 2]); bare words are taken as strings, since shells eat the
// quotes.
void apply_override(toml::table& root, const std::string& text) {
  const auto equals = text.find('=');
  if (equals == std::string::npos || equals == 0) {
    throw PlantFileError("override: found '" + text + "', expected section.key=value");
  }
  const std::string value = text.substr(equals + 1);
  toml::table parsed;
  try {
    parsed = toml::parse("v = " + value);
  } catch (const toml::parse_error&) {
    parsed.insert_or_assign("v", value);
  }
  // Copied through a fresh table so that the value carries no line number of the file.
  toml::table* table = &root;
  std::string_view path(text.data(), equals);
  const bool hidden = path.starts_with("hidden.");
  if (hidden) make_hidden(root, path);
  while (true) {
    const auto dot = path.find('.');
    const std::string_view key = path.substr(0, dot);
    if (dot == std::string_view::npos) {
      if (!table->contains(key)) {
        throw PlantFileError("override: " + text.substr(0, equals) +
                             ": the plant file has no such key");
      }
      const toml::node& node = *parsed.get("v");
      bool known = put_value(*table, key, node);
      if (!known && hidden && node.is_table()) {
        toml::table made;
        known = true;
        for (const auto& [inner, entry] : *node.as_table()) {
          known = known && put_value(made, inner.str(), entry);
        }
        table->insert_or_assign(key, std::move(made));
      }
      if (!known) {
        throw PlantFileError("override: found '" + text + "', expected a number, string or list");
      }
      return;
    }
    toml::node* next = table->get(key);
    if (next == nullptr || !next->is_table()) {
      throw PlantFileError("override: " + text.substr(0, equals) +
                           ": the plant file has no table '" + std::string(key) + "'");
    }
    table = next->as_table();
    path.remove_prefix(dot + 1);
  }
}

// The overrides for one of two robots.
std::vector<std::string> overrides_for(std::string_view robot, const toml::table& own,
                                       std::span<const std::string> overrides) {
  std::vector<std::string> chosen;
  for (const std::string& one : overrides) {
    const std::string first = one.substr(0, one.find_first_of(".="));
    if (first == robot)
      chosen.push_back(one.substr(first.size() + 1));
    else if (first != "upper" && first != "lower" && (first == "plant" || !own.contains(first)))
      chosen.push_back(one);
  }
  return chosen;
}

TwoRobotsParameters two_robots(toml::table root, const std::string& name,
                               std::span<const std::string> overrides) {
  for (const std::string& one : overrides) {
    const std::string first = one.substr(0, one.find_first_of(".="));
    if (first != "plant" && root.contains(first)) apply_override(root, one);
  }
  Fields all(name, "", root);
  Fields head = all.table("plant");
  const auto robot = [&]<class Parameters>(const char* key, Parameters& into) {
    const auto file = std::filesystem::path(name).parent_path() / head.text(key);
    PlantParameters read = read_plant_file(file, overrides_for(key, root, overrides));
    auto* wanted = std::get_if<Parameters>(&read);
    if (wanted == nullptr) head.fail(key, file.string() + " is a plant of another kind");
    into = std::move(*wanted);
  };
  TwoRobotsParameters parameters = two_robots_sections(Fields(name, "", root));
  robot("upper", parameters.upper);
  robot("lower", parameters.lower);
  return parameters;
}

}  // namespace

PlantParameters parse_plant_file(std::string_view text, const std::string& name,
                                 std::span<const std::string> overrides) {
  toml::table root;
  try {
    root = toml::parse(text, name);
  } catch (const toml::parse_error& error) {
    throw PlantFileError(name + ":" + std::to_string(error.source().begin.line) +
                         ": not TOML: " + std::string(error.description()));
  }
  const bool two = root["plant"]["kind"].value<std::string>() == "two-robots";
  for (const auto& override_text : overrides)
    if (!two) apply_override(root, override_text);
  // Switches of the emulated devices share the file; drivers/simulated/emulators reads and checks
  // them.
  root.erase("emulator");
  root.erase("wire");
  if (two) return two_robots(std::move(root), name, overrides);
  Fields all(name, "", root);
  Fields head = all.table("plant");
  const std::string kind = head.text("kind");
  if (kind == "linear-axis") return linear_axis_sections(std::move(all));
  if (kind == "micro-nano") return micro_nano_sections(std::move(all));
  if (kind == "min-angle") return min_angle_sections(std::move(all));
  if (kind == "delta-cube") return delta_cube_sections(std::move(all));
  head.fail("kind", "found '" + kind +
                        "', expected linear-axis, micro-nano, min-angle, two-robots or delta-cube");
}

PlantParameters read_plant_file(const std::filesystem::path& file,
                                std::span<const std::string> overrides) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  if (in) text << in.rdbuf();
  if (!in) {
    throw PlantFileError(file.string() + ": cannot be read, expected a plant file such as " +
                         "deploy/cells/linear-axis/plant.toml");
  }
  return parse_plant_file(text.str(), file.string(), overrides);
}

}  // namespace driftwise::simulated
