#pragma once
// Contents of a cell file, defaults included, as text by place and key: what two of them are
// compared by. Pure.

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "server/core/description/cell_description.h"

namespace driftwise::formats {

// Part of a cell that is compared as one thing.
struct CellPart {
  std::map<std::string, std::string> values;  // by key
  std::vector<std::string> affects;           // symbols whose meaning it may change
};
using CellParts = std::map<std::string, CellPart>;  // by place: "probe t07_degC"

// Keys of the text that this list does not know are compared as written.
CellParts cell_parts(const CellDescription& cell, std::string_view text);

// Of what a device measures, and of what that depends on.
std::vector<std::string> symbols_of(const CellDescription& cell, const DeviceDescription& device);

}  // namespace driftwise::formats
