#include "server/formats/size_text.h"

#include <array>
#include <cmath>
#include <cstdio>

namespace driftwise::formats {

std::string size_text(double size, const std::string& unit) {
  const bool is_length = unit == "nm";
  double shown = size;
  std::string shown_unit = unit;
  if (is_length && std::abs(size) >= 999.5e3) {
    shown = size / 1e6;
    shown_unit = "mm";
  } else if (is_length && std::abs(size) >= 9999.5) {
    shown = size / 1e3;
    shown_unit = "um";
  }
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%.*g", is_length ? 4 : 3, shown);
  return text.data() + (" " + shown_unit);
}

}  // namespace driftwise::formats
