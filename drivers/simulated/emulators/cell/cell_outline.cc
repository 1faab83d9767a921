#include "drivers/simulated/emulators/cell/cell_outline.h"

#include <time.h>
#include <toml++/toml.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <sstream>

#include "drivers/simulated/emulators/text.h"

namespace driftwise::simulated {
namespace {

[[noreturn]] void refuse(const std::filesystem::path& file, const toml::node* node,
                         const std::string& what) {
  std::string place = file.string() + ":";
  if (node != nullptr) place += std::to_string(node->source().begin.line) + ":";
  throw SetupError(place + " " + what);
}

toml::table parse(const std::string& text, const std::filesystem::path& file) {
  try {
    return toml::parse(text, file.string());
  } catch (const toml::parse_error& error) {
    throw SetupError(file.string() + ":" + std::to_string(error.source().begin.line) +
                     ": not TOML: " + std::string(error.description()));
  }
}

std::string text_field(const std::filesystem::path& file, const toml::table& table, const char* key,
                       const std::string& where) {
  const toml::node* node = table.get(key);
  if (node == nullptr || !node->is_string())
    refuse(file, node != nullptr ? node : &table,
           where + " " + key + ": expected a text in quotes");
  return node->as_string()->get();
}

}  // namespace

CellOutline read_cell_outline(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in)
    throw SetupError(
        file.string() +
        ": cannot be read, expected a cell file such as deploy/cells/linear-axis/cell.toml");
  CellOutline out{.file = file,
                  .text = {std::istreambuf_iterator<char>(in), {}},
                  .devices = {},
                  .epoch = {},
                  .clock_file = {}};
  const toml::table root = parse(out.text, file);
  const toml::array* devices = root["device"].as_array();
  if (devices == nullptr || devices->empty())
    refuse(file, nullptr, "expected at least one [[device]]");
  for (const auto& entry : *devices) {
    const toml::table* table = entry.as_table();
    if (table == nullptr) refuse(file, &entry, "device: expected [[device]]");
    DeviceOutline device{text_field(file, *table, "id", "device"), "", ""};
    const std::string where = "device '" + device.id + "'";
    device.kind = text_field(file, *table, "kind", where);
    device.address = text_field(file, *table, "address", where);
    for (const auto& other : out.devices)
      if (other.id == device.id) refuse(file, table->get("id"), where + ": the id stands twice");
    out.devices.push_back(std::move(device));
  }
  if (const toml::node* clock = root.get("clock"); clock != nullptr && clock->is_table()) {
    const toml::table& table = *clock->as_table();
    if (const toml::node* epoch = table.get("epoch")) {
      std::ostringstream text;
      if (epoch->is_string())
        text << epoch->as_string()->get();
      else if (epoch->is_date_time())
        text << epoch->as_date_time()->get();
      if (!text.str().empty()) try {
          out.epoch = parse_utc(text.str());
        } catch (const SetupError& error) {
          refuse(file, epoch, std::string("clock epoch: ") + error.what());
        }
    }
    if (const toml::node* speed = table.get("speed")) {
      out.speed = speed->value<double>().value_or(0);
      if (!(out.speed > 0)) refuse(file, speed, "clock speed: expected a number above 0");
    }
    if (const auto name = table["file"].value<std::string>()) out.clock_file = *name;
  }
  return out;
}

namespace {

// Edits by line: replaces a value where the parser found it, or adds a line below the table's
// header.
class Editor {
 public:
  explicit Editor(const std::string& text) {
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) lines_.push_back(line);
  }
  void set(const toml::table& table, const std::string& key, const std::string& value) {
    const toml::node* node = table.get(key);
    if (node == nullptr) {
      added_.push_back({table.source().begin.line, key + " = " + value});
      return;
    }
    const auto where = node->source();
    std::string& line = lines_[where.begin.line - 1];
    changes_.push_back({where.begin.line, where.begin.column - 1,
                        where.end.line == where.begin.line
                            ? where.end.column - 1
                            : static_cast<toml::source_index>(line.size()),
                        value});
  }
  void append(const std::string& line) { lines_.push_back(line); }
  std::string text() {
    // From right to left within a line, so that columns stay true.
    std::sort(changes_.begin(), changes_.end(),
              [](const Change& a, const Change& b) { return a.from > b.from; });
    for (const auto& change : changes_)
      lines_[change.line - 1].replace(change.from, change.to - change.from, change.value);
    std::string out;
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      out += lines_[i] + "\n";
      for (const auto& [after, line] : added_)
        if (after == i + 1) out += line + "\n";
    }
    return out;
  }

 private:
  struct Change {
    toml::source_index line, from, to;
    std::string value;
  };
  std::vector<std::string> lines_;
  std::vector<Change> changes_;
  std::vector<std::pair<toml::source_index, std::string>> added_;
};

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + "\"";
}

}  // namespace

std::string instance_text(const CellOutline& outline, const CellChanges& changes) {
  const toml::table root = parse(outline.text, outline.file);
  Editor editor(outline.text);
  for (const auto& entry : *root["device"].as_array()) {
    const toml::table& device = *entry.as_table();
    const std::string id = device["id"].value_or(std::string());
    for (const auto& [changed, address] : changes.addresses)
      if (changed == id) editor.set(device, "address", quoted(address));
  }
  if (const toml::table* cell = root["cell"].as_table()) {
    editor.set(*cell, "listen", quoted("127.0.0.1:0"));
    editor.set(*cell, "target_line", quoted("127.0.0.1:0"));
    editor.set(*cell, "http", quoted("127.0.0.1:0"));
  }
  if (const toml::table* clock = root["clock"].as_table()) {
    editor.set(*clock, "epoch", quoted(changes.epoch));
    editor.set(*clock, "speed", shortest(changes.speed));
    editor.set(*clock, "file", quoted(changes.clock_file));
  } else {
    editor.append("\n[clock]\nepoch = " + quoted(changes.epoch) + "\nspeed = " +
                  shortest(changes.speed) + "\nfile = " + quoted(changes.clock_file));
  }
  return editor.text();
}

TimeNs parse_utc(const std::string& text) {
  const SetupError wrong("found '" + text + "', expected a time such as 2026-11-21T08:00:00Z");
  tm parts{};
  const char* rest = ::strptime(text.c_str(), "%Y-%m-%dT%H:%M:%S", &parts);
  if (rest == nullptr) rest = ::strptime(text.c_str(), "%Y-%m-%d %H:%M:%S", &parts);
  if (rest == nullptr) throw wrong;
  TimeNs nanoseconds = 0;
  if (*rest == '.') {
    TimeNs unit = 100'000'000;
    for (++rest; is_digit(*rest); ++rest, unit /= 10) nanoseconds += (*rest - '0') * unit;
  }
  if (std::string_view(rest) != "Z" && std::string_view(rest) != "z") throw wrong;
  return static_cast<TimeNs>(::timegm(&parts)) * 1'000'000'000 + nanoseconds;
}

std::string utc_text(TimeNs time) {
  const time_t whole = static_cast<time_t>(time / 1'000'000'000);
  tm parts{};
  ::gmtime_r(&whole, &parts);
  char buffer[64];
  const std::size_t size = ::strftime(buffer, sizeof buffer, "%Y-%m-%dT%H:%M:%S", &parts);
  std::string fraction = std::to_string(time % 1'000'000'000);
  fraction.insert(0, 9 - std::min<std::size_t>(9, fraction.size()), '0');
  while (!fraction.empty() && fraction.back() == '0') fraction.pop_back();
  return std::string(buffer, size) + (fraction.empty() ? "" : "." + fraction) + "Z";
}

}  // namespace driftwise::simulated
