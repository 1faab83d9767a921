#include "server/formats/text/toml_reader.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include "server/core/reasons.h"
#include "server/core/text/clean_text.h"
#include "server/formats/text/text.h"

namespace driftwise::formats {
namespace {

std::string_view type_name(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::table:
      return "a table";
    case toml::node_type::array:
      return "an array";
    case toml::node_type::string:
      return "a string";
    case toml::node_type::integer:
      return "a whole number";
    case toml::node_type::floating_point:
      return "a number";
    case toml::node_type::boolean:
      return "true or false";
    default:
      return "a date or time";
  }
}

std::string plain_text(const toml::node& node) {
  if (const auto* text = node.as_string()) return text->get();
  if (const auto* number = node.as_integer()) return std::to_string(number->get());
  if (const auto* number = node.as_floating_point()) return number_text(number->get());
  if (const auto* truth = node.as_boolean()) return truth->get() ? "true" : "false";
  return {};
}

std::string found_text(const toml::node& node) {
  if (node.is_string()) return shown(*node.value<std::string_view>());
  const std::string plain = plain_text(node);
  return plain.empty() ? std::string(type_name(node)) : plain;
}

// A required key that is not there, and the key that may be a slip in its place.
std::string missing(const toml::table& table, const char* key,
                    const std::vector<std::string_view>& known) {
  std::vector<std::string_view> others;
  for (const auto& [found, node] : table)
    if (std::ranges::find(known, found.str()) == known.end()) others.push_back(found.str());
  const std::string nearest = nearest_word(key, others);
  return "found " + (nearest.empty() ? "nothing" : shown(nearest)) + ", expected this key";
}

}  // namespace

void TomlProblem::add(ErrorCode code, const std::string& reason, const toml::source_region& where,
                      const std::string& sentence) {
  if (!first) first = Error{code, reason, at_line(file_name, where.begin.line) + sentence};
}

Error syntax_error(const toml::parse_error& error, const std::string& file_name) {
  const std::string_view what = error.description();
  const bool comma_after_value = what.find("key-value pair") != std::string_view::npos &&
                                 what.find("saw ','") != std::string_view::npos;
  return {ErrorCode::invalid_argument, reasons::kTomlSyntax,
          at_line(file_name, error.source().begin.line) + "column " +
              std::to_string(error.source().begin.column) + ": " + std::string(what) +
              (comma_after_value ? ": decimals have a point, such as -25.0" : "")};
}

TomlReader::TomlReader(const toml::table& table, std::string place, TomlProblem& problem)
    : table_(table), place_(std::move(place)), problem_(problem) {}

const toml::node* TomlReader::find(const char* key, Need need) {
  known_.emplace_back(key);
  const toml::node* node = table_.get(key);
  if (!node && need == Need::required)
    refuse(key, reasons::kMissingKey, missing(table_, key, known_));
  return node;
}

void TomlReader::refuse(const char* key, Reason reason, const std::string& sentence,
                        ErrorCode code) {
  const toml::node* node = table_.get(key);
  problem_.add(code, reason, node ? node->source() : table_.source(),
               (place_.empty() ? "" : place_ + ": ") + key + ": " + sentence);
}

void TomlReader::wrong_type(const char* key, const toml::node& node, const char* expected) {
  refuse(key, reasons::kWrongType, "found " + found_text(node) + ", expected " + expected);
}

void TomlReader::text(const char* key, std::string& value, Need need) {
  const auto* node = find(key, need);
  if (!node) return;
  const auto* found = node->as_string();
  if (!found) return wrong_type(key, *node, "a string");
  if (found->get().empty() && need == Need::required)
    return refuse(key, reasons::kOutOfRange, "found an empty string, expected some text");
  if (clean_line(found->get()) != found->get())
    return refuse(
        key, reasons::kBadText,
        "found " + shown(found->get()) + ", expected one line without control characters");
  value = found->get();
}

void TomlReader::choice(const char* key, std::string& value,
                        std::span<const std::string_view> allowed, Need need) {
  const auto* node = find(key, Need::optional);
  if (!node && need == Need::optional) return;
  std::string list;
  for (const auto word : allowed) list += (list.empty() ? "" : ", ") + std::string(word);
  if (!node)
    return refuse(key, reasons::kMissingKey, missing(table_, key, known_) + ", one of " + list);
  const auto found = node->value<std::string_view>();
  if (found && std::ranges::find(allowed, *found) != allowed.end()) {
    value = *found;
    return;
  }
  refuse(key, std::string_view(key) == "kind" ? reasons::kUnknownKind : reasons::kOutOfRange,
         "found " + found_text(*node) + ", expected one of " + list);
}

void TomlReader::number(const char* key, double& value, Range range, Need need) {
  const auto* node = find(key, need);
  if (!node) return;
  if (!node->is_number()) return wrong_type(key, *node, "a number");
  const double found = *node->value<double>();
  // Seconds become a time: whatever the key allows, it is a duration that fits into one.
  const std::string_view name(key);
  if (name.ends_with("_s") && !name.ends_with("mm_s"))
    range.max = std::min(range.max, kMostAsked_s);
  const bool inside = std::isfinite(found) && found <= range.max &&
                      (range.above_min ? found > range.min : found >= range.min);
  if (inside) {
    value = found;
    return;
  }
  constexpr double kAny = std::numeric_limits<double>::max();
  std::string expected = "a finite number";
  if (range.min > -kAny)
    expected += (range.above_min ? " above " : " from ") + number_text(range.min);
  if (range.max < kAny) expected += " up to " + number_text(range.max);
  refuse(key, reasons::kOutOfRange, "found " + number_text(found) + ", expected " + expected);
}

void TomlReader::integer(const char* key, int& value, int min, int max, Need need) {
  const auto* node = find(key, need);
  if (!node) return;
  const auto* found = node->as_integer();
  if (!found) return wrong_type(key, *node, "a whole number");
  if (found->get() < min || found->get() > max)
    return refuse(key, reasons::kOutOfRange,
                  "found " + std::to_string(found->get()) + ", expected a whole number from " +
                      std::to_string(min) + " to " + std::to_string(max));
  value = static_cast<int>(found->get());
}

void TomlReader::truth(const char* key, bool& value) {
  const auto* node = find(key, Need::optional);
  if (!node) return;
  const auto* found = node->as_boolean();
  if (!found) return wrong_type(key, *node, "true or false");
  value = found->get();
}

void TomlReader::vector3(const char* key, std::array<double, 3>& value, double limit) {
  const auto* node = find(key, Need::optional);
  if (!node) return;
  const auto* list = node->as_array();
  if (!list || list->size() != value.size())
    return wrong_type(key, *node, "three numbers such as [0.4, -1.2, 0]");
  std::array<double, 3> found{};
  for (std::size_t i = 0; i < found.size(); ++i) {
    const auto& item = *list->get(i);
    if (!item.is_number()) return wrong_type(key, item, "a number in each of the three places");
    found[i] = *item.value<double>();
    if (!std::isfinite(found[i]) || std::abs(found[i]) > limit)
      return refuse(key, reasons::kOutOfRange,
                    "found " + number_text(found[i]) + ", expected a number from " +
                        number_text(-limit) + " to " + number_text(limit));
  }
  value = found;
}

void TomlReader::time(const char* key, CellTime& value) {
  const auto* node = find(key, Need::optional);
  if (!node) return;
  std::string text;
  if (const auto* found = node->as_string()) {
    text = found->get();
  } else if (const auto* date = node->as_date_time()) {
    std::ostringstream
        out;  // toml++ prints RFC 3339; only 'Z' is understood below, so a local time is refused
    out << date->get();
    text = out.str();
  } else {
    return wrong_type(key, *node, "a time such as 2011-07-22T08:00:00Z");
  }
  const auto time = parse_iso8601(text);
  if (!time)
    return refuse(key, reasons::kBadTime,
                  "found " + shown(text) + ", expected a time in UTC such as 2011-07-22T08:00:00Z");
  value = *time;
}

void TomlReader::channel(const char* key, Channel& value, Need need) {
  std::string name;
  text(key, name, need);
  if (name.empty()) return;
  auto channel = parse_channel(name);
  if (!channel) return refuse(key, reasons::kBadChannel, channel.error().message);
  value = std::move(*channel);
}

void TomlReader::robot_channel(const char* key, Channel& value, Need need) {
  std::string name;
  text(key, name, need);
  if (name.empty()) return;
  auto channel = parse_robot_channel(name);
  if (!channel) return refuse(key, reasons::kBadChannel, channel.error().message);
  value = std::move(*channel);
}

void TomlReader::strings(const char* key, std::map<std::string, std::string>& values) {
  const auto* inner = table(key);
  if (!inner) return;
  for (const auto& [name, node] : *inner) {
    if (node.is_table() || node.is_array() || node.is_date() || node.is_time() ||
        node.is_date_time())
      return refuse(key, reasons::kWrongType,
                    std::string(name.str()) + ": found " + std::string(type_name(node)) +
                        ", expected a string, a number, true or false");
    const std::string text = plain_text(node);
    if (clean_line(text) != text)
      return refuse(key, reasons::kBadText,
                    std::string(name.str()) + ": found " + shown(text) +
                        ", expected one line without control characters");
    values[std::string(name.str())] = text;
  }
}

const toml::table* TomlReader::table(const char* key) {
  const auto* node = find(key, Need::optional);
  if (!node) return nullptr;
  if (!node->is_table()) wrong_type(key, *node, "a table");
  return node->as_table();
}

std::vector<const toml::table*> TomlReader::tables(const char* key) {
  std::vector<const toml::table*> out;
  const auto* node = find(key, Need::optional);
  if (!node) return out;
  if (!node->is_array_of_tables()) {
    wrong_type(key, *node, "a list of tables, each under its own [[...]] line");
    return out;
  }
  for (const auto& item : *node->as_array()) out.push_back(item.as_table());
  return out;
}

void TomlReader::finish() {
  for (const auto& [key, node] : table_) {
    if (std::ranges::find(known_, key.str()) != known_.end()) continue;
    const std::string nearest = nearest_word(key.str(), known_);
    std::string list;
    for (const auto word : known_) list += (list.empty() ? "" : ", ") + std::string(word);
    problem_.add(
        ErrorCode::invalid_argument, reasons::kUnknownKey, key.source(),
        (place_.empty() ? "" : place_ + ": ") + "found the unknown key " + shown(key.str()) +
            (nearest.empty() ? ", expected one of " + list : ": did you mean " + nearest + "?"));
  }
}

}  // namespace driftwise::formats
