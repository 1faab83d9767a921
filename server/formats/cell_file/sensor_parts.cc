#include "server/formats/cell_file/sensor_parts.h"

#include <toml++/toml.h>

#include "server/core/channel.h"
#include "server/formats/text/toml_text.h"

namespace driftwise::formats {
namespace {

void add_parts_of(const toml::node& device, std::map<std::string, std::string>& parts) {
  const auto* table = device.as_table();
  const auto* probes = table ? table->get_as<toml::array>("probe") : nullptr;
  if (!probes) return;
  for (const auto& probe : *probes) {
    const auto* one = probe.as_table();
    if (!one) continue;
    const auto part = (*one)["part"].value<std::string>();
    const auto channel = parse_channel((*one)["channel"].value_or(std::string()));
    if (part && channel) parts[channel->symbol] = *part;
  }
}

}  // namespace

std::map<std::string, std::string> sensor_parts(std::string_view cell_text) {
  std::map<std::string, std::string> parts;
  try {
    const auto root = parse_toml(cell_text);
    if (const auto* devices = root.get_as<toml::array>("device"))
      for (const auto& device : *devices) add_parts_of(device, parts);
  } catch (const toml::parse_error&) {  // a description that was not made from a file
  }
  return parts;
}

}  // namespace driftwise::formats
