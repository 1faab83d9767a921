#include "server/core/data/dataset_parts.h"

#include <algorithm>
#include <sstream>

namespace driftwise {

Parts parts_from(const std::vector<std::pair<std::string, std::string>>& metadata) {
  Parts parts;
  for (const auto& [key, value] : metadata) {
    if (key != kPartsKey) continue;
    std::istringstream words(value);
    for (std::string word; words >> word;) {
      const auto equals = word.find('=');
      if (equals == std::string::npos || equals == 0) continue;
      const auto symbol = word.substr(0, equals);
      std::erase_if(parts, [&symbol](const auto& one) { return one.first == symbol; });
      parts.emplace_back(symbol, word.substr(equals + 1));
    }
  }
  return parts;
}

std::string parts_text(const Parts& parts) {
  std::string text;
  for (const auto& [symbol, part] : parts) text += (text.empty() ? "" : " ") + symbol + "=" + part;
  return text;
}

}  // namespace driftwise
