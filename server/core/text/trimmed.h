#pragma once
// Text without the blanks around it.

#include <string_view>

namespace driftwise {

// blanks: every character that counts as one. A part of text; empty: nothing but blanks.
constexpr std::string_view trimmed(std::string_view text, std::string_view blanks) {
  const auto first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

}  // namespace driftwise
