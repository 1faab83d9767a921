#include "server/formats/cell_file/setup_instruments.h"

#include <toml++/toml.h>

#include <set>

#include "server/core/channel.h"
#include "server/formats/text/toml_text.h"

namespace driftwise::formats {

std::map<std::string, std::string> setup_instruments(std::string_view cell_text,
                                                     std::string_view setup) {
  std::map<std::string, std::string> devices;
  try {
    const auto root = parse_toml(cell_text);
    const auto* setups = root.get_as<toml::array>("setup");
    for (std::size_t i = 0; setups != nullptr && i < setups->size(); ++i) {
      const auto* table = setups->get_as<toml::table>(i);
      if (table == nullptr || (*table)["name"].value_or(std::string()) != setup) continue;
      const auto* coordinates = table->get_as<toml::array>("coordinate");
      for (std::size_t k = 0; coordinates != nullptr && k < coordinates->size(); ++k) {
        const auto* one = coordinates->get_as<toml::table>(k);
        if (one == nullptr) continue;
        const auto channel = parse_robot_channel((*one)["channel"].value_or(std::string()));
        const auto device = (*one)["device"].value<std::string>();
        if (channel && device) devices[channel->symbol] = *device;
      }
    }
  } catch (const toml::parse_error&) {  // a description that was not made from a file
  }
  return devices;
}

std::map<std::string, std::string> length_instruments(std::string_view cell_text) {
  std::map<std::string, std::string> devices;
  std::set<std::string> several;
  try {
    const auto root = parse_toml(cell_text);
    const auto* all = root.get_as<toml::array>("device");
    for (std::size_t i = 0; all != nullptr && i < all->size(); ++i) {
      const auto* table = all->get_as<toml::table>(i);
      if (table == nullptr) continue;
      const auto channel = parse_robot_channel((*table)["length"].value_or(std::string()));
      const auto id = (*table)["id"].value<std::string>();
      if (channel && id && !devices.emplace(channel->symbol, *id).second)
        several.insert(channel->symbol);
    }
  } catch (const toml::parse_error&) {  // likewise
  }
  for (const auto& symbol : several) devices.erase(symbol);
  return devices;
}

}  // namespace driftwise::formats
