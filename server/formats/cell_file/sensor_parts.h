#pragma once
// Places of a cell's temperature sensors, from the text of its file alone.

#include <map>
#include <string>
#include <string_view>

namespace driftwise::formats {

// Symbol of each [[device.probe]] and its part: t07 -> robot. Empty for a text that is no TOML;
// what else the file says is not checked.
std::map<std::string, std::string> sensor_parts(std::string_view cell_text);

}  // namespace driftwise::formats
