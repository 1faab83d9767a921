// The keys of a TOML table that hold lists.

#include <cmath>

#include "server/core/reasons.h"
#include "server/formats/text/text.h"
#include "server/formats/text/toml_reader.h"

namespace driftwise::formats {

void TomlReader::texts(const char* key, std::vector<std::string>& values, Need need) {
  const auto* node = find(key, need);
  if (!node) return;
  std::vector<std::string> found;
  if (const auto* one = node->as_string()) found.push_back(one->get());
  if (const auto* list = node->as_array()) {
    for (const auto& item : *list) {
      const auto* text = item.as_string();
      if (!text) return wrong_type(key, item, "a list of strings");
      found.push_back(text->get());
    }
  } else if (!node->is_string()) {
    return wrong_type(key, *node, "a list of strings");
  }
  values = std::move(found);
}

bool TomlReader::read_numbers(const char* key, const toml::node& node,
                              std::vector<double>& values) {
  const auto* list = node.as_array();
  if (!list) return wrong_type(key, node, "a list of numbers"), false;
  for (const auto& item : *list) {
    const auto number = item.is_number() ? item.value<double>() : std::nullopt;
    if (!number || !std::isfinite(*number))
      return wrong_type(key, item, "a list of finite numbers"), false;
    values.push_back(*number);
  }
  return true;
}

void TomlReader::numbers(const char* key, std::vector<double>& values, std::size_t count) {
  const auto* node = find(key, Need::optional);
  if (!node) return;
  std::vector<double> found;
  if (!read_numbers(key, *node, found)) return;
  if (found.size() != count)
    return refuse(
        key, reasons::kOutOfRange,
        "found " + std::to_string(found.size()) + " numbers, expected " + std::to_string(count));
  values = std::move(found);
}

void TomlReader::numbers(const char* key, std::vector<double>& values) {
  const auto* node = find(key, Need::optional);
  std::vector<double> found;
  if (node && read_numbers(key, *node, found)) values = std::move(found);
}

void TomlReader::matrix(const char* key, std::vector<std::vector<double>>& rows) {
  const auto* node = find(key, Need::optional);
  if (!node) return;
  const auto* list = node->as_array();
  if (!list) return wrong_type(key, *node, "a list of rows, each a list of numbers");
  std::vector<std::vector<double>> found;
  for (const auto& item : *list) {
    std::vector<double> row;
    if (!read_numbers(key, item, row)) return;
    found.push_back(std::move(row));
    if (found.back().size() != found.front().size())
      return refuse(key, reasons::kOutOfRange,
                    "found rows of " + std::to_string(found.front().size()) + " and " +
                        std::to_string(found.back().size()) + " numbers, expected one length");
  }
  rows = std::move(found);
}

void TomlReader::text_or_integer(const char* key, std::string& text, int& number, int min, int max,
                                 Need need) {
  const auto* node = find(key, need);
  if (!node) return;
  if (const auto* found = node->as_string()) {
    text = found->get();
    if (text.empty())
      refuse(key, reasons::kOutOfRange, "found an empty string, expected some text");
    return;
  }
  if (!node->is_integer()) return wrong_type(key, *node, "a string or a whole number");
  integer(key, number, min, max);
}

}  // namespace driftwise::formats
