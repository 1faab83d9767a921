#pragma once
// Words and numbers of one text line, as several codecs read them. Pure.

#include <charconv>
#include <string_view>
#include <vector>

namespace driftwise::transport {

// Parted by blanks, tabs and line ends.
std::vector<std::string_view> words_of(std::string_view text);

// The whole text is the number, a plus sign allowed; else false.
template <class Number>
bool read_number(std::string_view text, Number& value) {
  if (text.starts_with('+')) text.remove_prefix(1);
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  return code == std::errc{} && end == text.data() + text.size();
}

}  // namespace driftwise::transport
