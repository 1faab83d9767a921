#include "drivers/simulated/emulators/switches.h"

#include <algorithm>

#include "drivers/simulated/emulators/text.h"

namespace driftwise::simulated {

Switches::Switches(std::string where, const std::vector<SwitchDescription>& declared)
    : where_(std::move(where)) {
  for (const auto& one : declared) values_.emplace(one.name, one.default_value);
}

void Switches::set(const std::string& name, const std::string& value) {
  const auto found = values_.find(name);
  if (found == values_.end()) {
    std::string known;
    for (const auto& [key, unused] : values_) known += (known.empty() ? "" : ", ") + key;
    throw SetupError(where_ + ": there is no switch '" + name + "'; there are " + known);
  }
  found->second = value;
}

const std::string& Switches::text(std::string_view name) const {
  const auto found = values_.find(name);
  if (found == values_.end()) throw std::logic_error("undeclared switch " + std::string(name));
  return found->second;
}

std::string Switches::escaped_text(std::string_view name) const {
  const std::string& raw = text(name);
  std::string out;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    if (raw[i] != '\\') {
      out += raw[i];
      continue;
    }
    const char kind = i + 1 < raw.size() ? raw[i + 1] : '\0';
    if (kind == 'r' || kind == 'n' || kind == 't' || kind == '\\') {
      out += kind == 'r' ? '\r' : kind == 'n' ? '\n' : kind == 't' ? '\t' : '\\';
      i += 1;
    } else if (kind == 'x' && i + 3 < raw.size()) {
      const auto byte = hex_number(std::string_view(raw).substr(i + 2, 2));
      if (!byte) refuse(name, "\\xHH with two hex digits");
      out += static_cast<char>(*byte);
      i += 3;
    } else {
      refuse(name, "text with \\r, \\n, \\t, \\\\ or \\xHH");
    }
  }
  return out;
}

bool Switches::flag(std::string_view name) const {
  const std::string value = upper(text(name));
  if (value == "TRUE" || value == "ON" || value == "1") return true;
  if (value == "FALSE" || value == "OFF" || value == "0") return false;
  refuse(name, "true or false");
}

double Switches::number(std::string_view name, double min, double max) const {
  const auto value = parse_number(text(name));
  if (!value || !(*value >= min && *value <= max))
    refuse(name, "a number from " + shortest(min) + " to " + shortest(max));
  return *value;
}

int Switches::integer(std::string_view name, int min, int max) const {
  const double value = number(name, min, max);
  if (value != static_cast<int>(value)) refuse(name, "a whole number");
  return static_cast<int>(value);
}

std::string Switches::choice(std::string_view name,
                             const std::vector<std::string_view>& allowed) const {
  if (std::find(allowed.begin(), allowed.end(), text(name)) != allowed.end()) return text(name);
  std::string list;
  for (const auto one : allowed) list += (list.empty() ? "" : " | ") + std::string(one);
  refuse(name, list);
}

std::vector<std::string> Switches::words(std::string_view name) const {
  std::string blanks = text(name);
  std::replace(blanks.begin(), blanks.end(), ',', ' ');
  std::vector<std::string> out;
  for (const auto word : split_blanks(blanks)) out.emplace_back(word);
  return out;
}

void Switches::refuse(std::string_view name, const std::string& expected) const {
  throw SetupError(where_ + " " + std::string(name) + ": found '" + text(name) + "', expected " +
                   expected);
}

}  // namespace driftwise::simulated
