#include "drivers/simulated/emulators/keithley_2701/scpi.h"

#include <algorithm>
#include <map>
#include <utility>

#include "drivers/simulated/emulators/text.h"

namespace driftwise::simulated {
namespace {

constexpr std::size_t kMnemonicLimit = 12;  // SCPI-99 6.2.1

bool is_form(const std::string& typed, const std::string& form) {
  return typed == form ||
         (typed.size() == form.size() + 1 && typed.ends_with('1') && typed.starts_with(form));
}

}  // namespace

std::string scpi_error_text(int code) {
  static const std::map<int, const char*> kTexts{
      {0, "No error"},
      {-101, "Invalid character"},
      {-102, "Syntax error"},
      {-104, "Data type error"},
      {-108, "Parameter not allowed"},
      {-109, "Missing parameter"},
      {-112, "Program mnemonic too long"},
      {-113, "Undefined header"},
      {-141, "Invalid character data"},
      {-151, "Invalid string data"},
      {-211, "Trigger ignored"},
      {-213, "Init ignored"},
      {-214, "Trigger deadlock"},
      {-221, "Settings conflict"},
      {-222, "Parameter data out of range"},
      {-223, "Too much data"},
      {-224, "Illegal parameter value"},
      {-230, "Data corrupt or stale"},
      {-350, "Queue overflow"},
      {-363, "Input buffer overrun"},
      {-410, "Query interrupted"},
      {-420, "Query unterminated"},
      {-440, "Query unterminated after indefinite response"},
      {517, "Cannot resume scan"},
      {520, "Saved setup scancard mismatch"},
      {523, "Card hardware error"},
      {524, "Unsupported card detected"},
  };
  const auto found = kTexts.find(code);
  return std::to_string(code) + ",\"" + (found == kTexts.end() ? "Device error" : found->second) +
         "\"";
}

void ScpiErrorQueue::push(int code) {
  if (codes_.size() < depth_)
    codes_.push_back(code);
  else
    codes_.back() = -350;
}

std::string ScpiErrorQueue::pop() {
  if (codes_.empty()) return scpi_error_text(0);
  const int code = codes_.front();
  codes_.pop_front();
  return scpi_error_text(code);
}

std::vector<std::string> split_units(std::string_view message) {
  std::vector<std::string> out{""};
  char quote = '\0';
  for (const char c : message) {
    if (quote == '\0' && c == ';') {
      out.emplace_back();
      continue;
    }
    if (quote == '\0' && (c == '\'' || c == '"'))
      quote = c;
    else if (c == quote)
      quote = '\0';
    out.back() += c;
  }
  return out;
}

ScpiParse parse_unit(std::string_view text) {
  text = trim(text);
  if (text.empty()) return {};
  if (std::any_of(text.begin(), text.end(),
                  [](char c) { return (c < ' ' && c != '\t') || c > '~'; }))
    return {.unit = {}, .error = -101};
  const std::size_t cut = std::min(text.find_first_of(" \t"), text.size());
  std::string header = upper(text.substr(0, cut));
  ScpiUnit unit;
  if (header.ends_with('?')) {
    unit.query = true;
    header.pop_back();
  }
  unit.common = header.starts_with('*');
  unit.absolute = header.starts_with(':');
  std::string_view rest = header;
  if (unit.absolute) rest.remove_prefix(1);
  std::string node;
  for (std::size_t i = 0; i <= rest.size(); ++i) {
    if (i == rest.size() || rest[i] == ':') {
      if (node.empty() || node == "*") return {.unit = {}, .error = -102};
      if (node.size() > kMnemonicLimit + 1) return {.unit = {}, .error = -112};
      unit.nodes.push_back(std::exchange(node, {}));
    } else if (is_letter(rest[i]) || (is_digit(rest[i]) && !node.empty()) || rest[i] == '_' ||
               (rest[i] == '*' && i == 0)) {
      node += rest[i];
    } else {
      return {.unit = {}, .error = -102};
    }
  }
  unit.arguments = split_arguments(text.substr(cut));
  return {.unit = std::move(unit)};
}

void ScpiTree::add(std::string_view pattern, Handler command, Handler query) {
  Entry entry{{}, std::move(command), std::move(query)};
  bool optional = false;
  std::string node;
  const auto finish = [&] {
    if (node.empty()) return;
    std::string short_form;
    for (const char c : node)
      if (!(c >= 'a' && c <= 'z')) short_form += c;
    entry.nodes.push_back({upper(node), short_form, optional});
    node.clear();
  };
  for (const char c : pattern) {
    if (c == '[' || c == ']' || c == ':') {
      finish();
      if (c == '[') optional = true;
      if (c == ']') optional = false;
    } else {
      node += c;
    }
  }
  finish();
  entries_.push_back(std::move(entry));
}

bool ScpiTree::matches(const std::vector<Node>& pattern, std::size_t p,
                       const std::vector<std::string>& nodes, std::size_t n) {
  if (p == pattern.size()) return n == nodes.size();
  const Node& want = pattern[p];
  if (n < nodes.size() &&
      (is_form(nodes[n], want.long_form) || is_form(nodes[n], want.short_form)) &&
      matches(pattern, p + 1, nodes, n + 1))
    return true;
  return want.optional && matches(pattern, p + 1, nodes, n);
}

ScpiAnswer ScpiTree::call(const ScpiUnit& unit, std::vector<std::string>& path) const {
  std::vector<std::string> nodes;
  if (!unit.common && !unit.absolute) nodes = path;
  nodes.insert(nodes.end(), unit.nodes.begin(), unit.nodes.end());
  if (nodes.size() > 16) return scpi_error(-113);
  for (const auto& entry : entries_) {
    if (!matches(entry.nodes, 0, nodes, 0)) continue;
    const Handler& handler = unit.query ? entry.query : entry.command;
    if (!handler) break;
    if (!unit.common) {
      nodes.pop_back();
      path = std::move(nodes);
    }
    return handler(unit.arguments);
  }
  return scpi_error(-113);
}

}  // namespace driftwise::simulated
