#include "server/formats/cell_file/cell_file_difference.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "server/formats/cell_file/cell_file.h"
#include "server/formats/cell_file/cell_parts.h"
#include "server/formats/cell_file/without_secrets.h"

namespace driftwise::formats {
namespace {

bool is_recorded_only(const std::string& place, const std::string& key) {
  const std::string kind = place.substr(0, place.find(' '));
  for (const char* section :
       {"cell", "access", "web", "clock", "run", "serving", "backup", "thinning", "alarm", "alarms",
        "channel_alarm", "notify", "watchdog", "log", "certificate"})
    if (kind == section) return true;
  if (kind == "device")
    return key == "port" || key == "timeout_s" || key == "period_s" || key == "identity";
  return place == "kinematics" && key == "hold";
}

std::string shown_part(const CellPart& part) {
  std::string text;
  for (const auto& [key, value] : part.values) {
    if (value.empty() || value == "0" || key == "port") continue;
    text += (text.empty() ? "" : ", ") + key + " " + value_without_secrets(key, value);
  }
  return text.empty() ? "given" : text;
}

std::string value_in(const CellPart* part, const std::string& key) {
  if (part == nullptr) return {};
  const auto found = part->values.find(key);
  return found == part->values.end() ? std::string() : found->second;
}

void add_symbols(const CellPart* part, std::vector<std::string>& out) {
  if (part) out.insert(out.end(), part->affects.begin(), part->affects.end());
}

void sort_once(std::vector<std::string>& names) {
  std::ranges::sort(names);
  const auto again = std::ranges::unique(names);
  names.erase(again.begin(), again.end());
}

// Devices whose new addresses are one another's old ones.
std::set<std::string> exchanged_devices(const CellDescription& before,
                                        const CellDescription& after) {
  std::map<std::string, std::string> owner, goes_to;  // old address -> id; id -> id
  for (const auto& device : before.devices) owner[device.address] = device.id;
  for (const auto& device : after.devices) {
    const auto found = owner.find(device.address);
    if (found != owner.end() && found->second != device.id && before.find_device(device.id))
      goes_to[device.id] = found->second;
  }
  std::set<std::string> exchanged;
  for (const auto& [id, first] : goes_to) {
    std::string at = first;
    for (std::size_t step = 0; step < goes_to.size() && at != id; ++step) {
      const auto next = goes_to.find(at);
      if (next == goes_to.end()) break;
      at = next->second;
    }
    if (at == id) exchanged.insert(id);
  }
  return exchanged;
}

}  // namespace

std::vector<ConfigurationChange> cell_file_difference(std::string_view before_text,
                                                      const CellDescription& after) {
  if (before_text == after.text) return {};
  const auto before = parse_cell_file(before_text, "cell.toml", after.kinds);
  std::vector<ConfigurationChange> changes;
  if (!before) {
    ConfigurationChange whole{
        "cell file",       "",   "one that this program cannot read: " + before.error().message,
        "the present one", true, {}};
    for (const auto& device : after.devices)
      for (auto& symbol : symbols_of(after, device)) whole.affects.push_back(std::move(symbol));
    if (after.load) whole.affects.emplace_back("force");
    sort_once(whole.affects);
    return {whole};
  }
  const CellParts was = cell_parts(*before, before_text), is = cell_parts(after, after.text);
  const auto exchanged = exchanged_devices(*before, after);
  std::set<std::string> places;
  for (const auto& [place, part] : was) places.insert(place);
  for (const auto& [place, part] : is) places.insert(place);
  for (const auto& place : places) {
    const auto old = was.find(place), now = is.find(place);
    const CellPart* from = old == was.end() ? nullptr : &old->second;
    const CellPart* to = now == is.end() ? nullptr : &now->second;
    std::vector<std::string> affects;
    add_symbols(from, affects);
    add_symbols(to, affects);
    sort_once(affects);
    if (!from || !to) {
      const bool asks = !is_recorded_only(place, "");
      changes.push_back({place, "", from ? shown_part(*from) : "", to ? shown_part(*to) : "", asks,
                         asks ? affects : std::vector<std::string>()});
      continue;
    }
    std::set<std::string> keys;
    for (const auto& [key, value] : from->values) keys.insert(key);
    for (const auto& [key, value] : to->values) keys.insert(key);
    const bool is_exchanged = place.starts_with("device ") && exchanged.contains(place.substr(7));
    for (const auto& key : keys) {
      const auto a = value_in(from, key), b = value_in(to, key);
      if (a == b) continue;
      const bool asks = !is_recorded_only(place, key) || (is_exchanged && key == "port");
      changes.push_back({place, key, value_without_secrets(key, a), value_without_secrets(key, b),
                         asks, asks ? affects : std::vector<std::string>()});
    }
  }
  std::ranges::stable_sort(changes, std::ranges::greater{}, &ConfigurationChange::asks);
  return changes;
}

bool any_asks(const std::vector<ConfigurationChange>& changes) {
  return std::ranges::any_of(changes, &ConfigurationChange::asks);
}

std::string sentence(const ConfigurationChange& change) {
  if (change.key.empty()) {
    if (change.before.empty()) return change.place + ": new: " + change.after;
    if (change.after.empty()) return change.place + ": gone: " + change.before;
  }
  const auto shown = [](const std::string& value) { return value.empty() ? "not given" : value; };
  return change.place + ": " + (change.key.empty() ? "" : change.key + " ") + shown(change.before) +
         " -> " + shown(change.after);
}

std::string write_changes_json(const std::vector<ConfigurationChange>& changes) {
  auto json = nlohmann::ordered_json::array();
  for (const auto& change : changes)
    json.push_back({{"place", change.place},
                    {"key", change.key},
                    {"before", change.before},
                    {"after", change.after},
                    {"asks", change.asks},
                    {"affects", change.affects}});
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::vector<ConfigurationChange> read_changes_json(const std::string& text) {
  const auto json = nlohmann::json::parse(text, nullptr, false);
  std::vector<ConfigurationChange> changes;
  if (!json.is_array()) return changes;
  for (const auto& one : json) {
    if (!one.is_object()) return {};
    ConfigurationChange change;
    change.place = one.value("place", "");
    change.key = one.value("key", "");
    change.before = value_without_secrets(change.key, one.value("before", ""));
    change.after = value_without_secrets(change.key, one.value("after", ""));
    change.asks = one.value("asks", true);
    change.affects = one.value("affects", std::vector<std::string>());
    changes.push_back(std::move(change));
  }
  return changes;
}

}  // namespace driftwise::formats
