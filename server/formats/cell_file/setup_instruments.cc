#include "server/formats/cell_file/setup_instruments.h"

#include <toml++/toml.h>

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

}  // namespace driftwise::formats
