#pragma once
// Numbers as other programs write them: "1.234,5", "+3,02E-5".

#include <optional>
#include <string_view>

namespace driftwise::formats {

struct NumberStyle {
  char decimal = '.';
  char thousands = 0;  // 0: none
};

// The finite number that is the whole of the text, correctly rounded; nothing otherwise. A
// thousands mark stands between groups of three digits before the decimal mark.
// shift: moves the decimal point to the right before the rounding: 3 turns "0,1" m into 100 mm.
std::optional<double> number_in(std::string_view text, const NumberStyle& style, int shift = 0);

}  // namespace driftwise::formats
