#include "drivers/simulated/plant/file/plant_fields.h"

#include <cmath>
#include <sstream>

#include "drivers/simulated/plant/file/make_plant.h"

namespace driftwise::simulated {
namespace {

std::string shown(const toml::node& found) {
  std::ostringstream out;
  if (const auto* text = found.as_string()) {
    out << '\'' << text->get() << "' (string)";
  } else if (const auto* whole = found.as_integer()) {
    out << whole->get();
  } else if (const auto* number = found.as_floating_point()) {
    out << number->get();
  } else {
    out << "a value of type " << found.type();
  }
  return out.str();
}

std::string text_of(double value) {
  std::ostringstream out;
  out << value;
  return out.str();
}

}  // namespace

std::string Fields::place(const toml::node* found, std::string_view key) const {
  const toml::node& at = found != nullptr ? *found : table_;
  const auto line = at.source().begin.line;
  std::string text = line == 0 ? "override" : file_ + ":" + std::to_string(line);
  text += ": ";
  text += path_;
  if (!path_.empty() && !key.empty()) text += '.';
  text += key;
  return text + ": ";
}

void Fields::fail(std::string_view key, std::string_view what) const {
  throw PlantFileError(place(table_.get(key), key) + std::string(what));
}

void Fields::wrong(std::string_view key, const toml::node& found, std::string_view expected) const {
  throw PlantFileError(place(&found, key) + "found " + shown(found) + ", expected " +
                       std::string(expected));
}

const toml::node& Fields::node(std::string_view key, std::string_view expected) {
  read_.emplace(key);
  const toml::node* found = table_.get(key);
  if (found == nullptr) {
    throw PlantFileError(place(nullptr, key) + "found nothing, expected " + std::string(expected));
  }
  return *found;
}

double Fields::number(std::string_view key) {
  const toml::node& found = node(key, "a number");
  const auto value = found.value<double>();
  if (!found.is_number() || !value || !std::isfinite(*value)) wrong(key, found, "a number");
  return *value;
}

double Fields::positive(std::string_view key) {
  const toml::node& found = node(key, "a number above 0");
  const auto value = found.is_number() ? found.value<double>() : std::nullopt;
  if (!value || !std::isfinite(*value) || *value <= 0) wrong(key, found, "a number above 0");
  return *value;
}

double Fields::not_negative(std::string_view key) {
  const toml::node& found = node(key, "a number, 0 or more");
  const auto value = found.is_number() ? found.value<double>() : std::nullopt;
  if (!value || !std::isfinite(*value) || *value < 0) wrong(key, found, "a number, 0 or more");
  return *value;
}

double Fields::within(std::string_view key, double low, double high) {
  const std::string expected = "a number from " + text_of(low) + " to " + text_of(high);
  const toml::node& found = node(key, expected);
  const auto value = found.is_number() ? found.value<double>() : std::nullopt;
  if (!value || !(*value >= low && *value <= high)) wrong(key, found, expected);
  return *value;
}

int Fields::whole(std::string_view key, int low, int high) {
  const std::string expected =
      "a whole number from " + std::to_string(low) + " to " + std::to_string(high);
  const toml::node& found = node(key, expected);
  const auto* value = found.as_integer();
  if (value == nullptr || value->get() < low || value->get() > high) wrong(key, found, expected);
  return static_cast<int>(value->get());
}

std::string Fields::text(std::string_view key) {
  const toml::node& found = node(key, "a string");
  const auto* value = found.as_string();
  if (value == nullptr) wrong(key, found, "a string");
  return value->get();
}

std::string Fields::text_or(std::string_view key, std::string_view fallback) {
  read_.emplace(key);
  return has(key) ? text(key) : std::string(fallback);
}

std::vector<std::string> Fields::texts(std::string_view key) {
  const toml::node& found = node(key, "a list of strings");
  const auto* list = found.as_array();
  if (list == nullptr || list->empty()) wrong(key, found, "a list of at least one string");
  std::vector<std::string> values;
  for (const auto& item : *list) {
    if (!item.is_string()) wrong(key, item, "a string");
    values.push_back(item.as_string()->get());
  }
  return values;
}

std::vector<double> Fields::numbers(std::string_view key, std::size_t count) {
  const std::string expected = "a list of " + std::to_string(count) + " numbers";
  const toml::node& found = node(key, expected);
  const auto* items = found.as_array();
  if (items == nullptr || items->size() != count) wrong(key, found, expected);
  std::vector<double> values;
  for (const auto& item : *items) {
    if (!item.is_number() || !std::isfinite(*item.value<double>())) wrong(key, item, "a number");
    values.push_back(*item.value<double>());
  }
  return values;
}

std::vector<std::vector<double>> Fields::rows(std::string_view key, std::size_t width) {
  const std::string expected = "a list of lists of " + std::to_string(width) + " numbers";
  const toml::node& found = node(key, expected);
  const auto* list = found.as_array();
  if (list == nullptr) wrong(key, found, expected);
  std::vector<std::vector<double>> values;
  for (const auto& row : *list) {
    const auto* items = row.as_array();
    if (items == nullptr || items->size() != width) wrong(key, row, expected);
    auto& numbers = values.emplace_back();
    for (const auto& item : *items) {
      if (!item.is_number() || !std::isfinite(*item.value<double>())) wrong(key, item, "a number");
      numbers.push_back(*item.value<double>());
    }
  }
  return values;
}

Fields Fields::table(std::string_view key) {
  const toml::node& found = node(key, "a table");
  if (!found.is_table()) wrong(key, found, "a table");
  std::string path = path_.empty() ? std::string(key) : path_ + "." + std::string(key);
  return {file_, std::move(path), *found.as_table()};
}

std::vector<std::string> Fields::table_names() {
  std::vector<std::string> names;
  for (const auto& [key, value] : table_) {
    if (!value.is_table()) wrong(key.str(), value, "a table");
    names.emplace_back(key.str());
  }
  return names;
}

void Fields::finish() const {
  for (const auto& [key, value] : table_) {
    if (read_.contains(key.str())) continue;
    std::string known;
    for (const auto& name : read_) known += (known.empty() ? "" : ", ") + name;
    throw PlantFileError(place(&value, key.str()) +
                         "found a key that means nothing here, expected " + known);
  }
}

}  // namespace driftwise::simulated
