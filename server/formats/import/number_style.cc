#include "server/formats/import/number_style.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>

namespace driftwise::formats {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

// The whole part without its thousands marks; false when they do not part it by threes.
bool append_whole_part(std::string& plain, std::string_view text, char thousands) {
  std::size_t since_mark = 0;
  bool marked = false;
  for (const char c : text) {
    if (is_digit(c)) {
      plain += c;
      ++since_mark;
      continue;
    }
    if (thousands == 0 || c != thousands || since_mark == 0) return false;
    if (marked ? since_mark != 3 : since_mark > 3) return false;
    marked = true;
    since_mark = 0;
  }
  return !marked || since_mark == 3;
}

// The exponent after the e: "+3", "-05", "7".
bool read_exponent(std::string_view text, int& exponent) {
  if (text.starts_with('+')) {
    text.remove_prefix(1);
    if (text.starts_with('-')) return false;
  }
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), exponent);
  return code == std::errc{} && end == text.data() + text.size() && exponent > -10000 &&
         exponent < 10000;
}

}  // namespace

std::optional<double> number_in(std::string_view text, const NumberStyle& style, int shift) {
  std::string plain;  // as std::from_chars wants it
  if (!text.empty() && (text.front() == '+' || text.front() == '-')) {
    if (text.front() == '-') plain += '-';
    text.remove_prefix(1);
  }
  int exponent = 0;
  if (const auto mark = text.find_first_of("eE"); mark != std::string_view::npos) {
    if (!read_exponent(text.substr(mark + 1), exponent)) return std::nullopt;
    text = text.substr(0, mark);
  }
  const auto point = text.find(style.decimal);
  if (!append_whole_part(plain, text.substr(0, point), style.thousands)) return std::nullopt;
  if (point != std::string_view::npos) {
    const std::string_view fraction = text.substr(point + 1);
    if (!std::ranges::all_of(fraction, is_digit)) return std::nullopt;
    plain += '.';
    plain += fraction;
  }
  // From here on a lone sign or point is the only thing that is no number.
  plain += "e" + std::to_string(exponent + shift);
  double value = 0;
  const auto [end, code] = std::from_chars(plain.data(), plain.data() + plain.size(), value);
  if (code != std::errc{} || end != plain.data() + plain.size() || !std::isfinite(value))
    return std::nullopt;
  return value;
}

}  // namespace driftwise::formats
