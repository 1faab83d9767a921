#include "drivers/transport/options.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "server/core/reasons.h"

namespace driftwise::transport {

const std::string* OptionReader::given(const std::string& name) {
  known_.push_back(name);
  const auto found = device_.options.find(name);
  return found == device_.options.end() ? nullptr : &found->second;
}

void OptionReader::complain(const std::string& name, const std::string& found,
                            const std::string& expected) {
  if (problem_) return;
  problem_ = Error{ErrorCode::invalid_argument, reasons::kBadOption,
                   "device '" + device_.id + "' (" + device_.kind + "): option " + name + " = '" +
                       found + "', expected " + expected};
}

std::string OptionReader::text(const std::string& name, std::string fallback) {
  const std::string* value = given(name);
  return value ? *value : std::move(fallback);
}

std::string OptionReader::choice(const std::string& name, std::string fallback,
                                 std::initializer_list<const char*> allowed) {
  const std::string* value = given(name);
  if (!value) return fallback;
  std::string list;
  for (const char* word : allowed) {
    if (*value == word) return *value;
    list += (list.empty() ? "" : " | ") + std::string(word);
  }
  complain(name, *value, list);
  return fallback;
}

bool OptionReader::on_off(const std::string& name, bool fallback) {
  const std::string word = choice(name, fallback ? "on" : "off", {"on", "off", "true", "false"});
  return word == "on" || word == "true";
}

double OptionReader::number(const std::string& name, double fallback, double min, double max) {
  const std::string* value = given(name);
  if (!value) return fallback;
  double number = 0;
  const auto [end, code] = std::from_chars(value->data(), value->data() + value->size(), number);
  if (code == std::errc{} && end == value->data() + value->size() && number >= min && number <= max)
    return number;
  char range[96];
  std::snprintf(range, sizeof range, "a number from %g to %g", min, max);
  complain(name, *value, range);
  return fallback;
}

int OptionReader::integer(const std::string& name, int fallback, int min, int max) {
  const double value = number(name, fallback, min, max);
  if (value == std::floor(value)) return static_cast<int>(value);
  complain(name, device_.options.at(name), "a whole number");
  return fallback;
}

Result<void> OptionReader::finish() const {
  if (problem_) return tl::unexpected(*problem_);
  for (const auto& [name, value] : device_.options) {
    if (std::find(known_.begin(), known_.end(), name) != known_.end()) continue;
    std::string list;
    for (const auto& known : known_) list += (list.empty() ? "" : ", ") + known;
    return fail(ErrorCode::invalid_argument, reasons::kBadOption,
                "device '" + device_.id + "' (" + device_.kind + "): unknown option '" + name +
                    "'; known are " + list);
  }
  return {};
}

}  // namespace driftwise::transport
