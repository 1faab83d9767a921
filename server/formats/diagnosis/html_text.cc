#include "server/formats/diagnosis/html_text.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace driftwise::formats {
namespace {

constexpr const char* kMinus = "\xE2\x88\x92";
constexpr const char* kThinSpace = "\xE2\x80\x89";
constexpr int kMostDecimals = 12;

// Groups of three before the decimal point, from five digits on.
std::string grouped(const std::string& digits) {
  const auto point = std::min(digits.find('.'), digits.size());
  if (point < 5) return digits;
  std::string text;
  for (std::size_t i = 0; i < point; ++i) {
    if (i > 0 && (point - i) % 3 == 0) text += kThinSpace;
    text += digits[i];
  }
  return text + digits.substr(point);
}

}  // namespace

std::string html_escaped(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string figure_text(double value, int digits) {
  if (!std::isfinite(value)) return "\xE2\x80\x93";  // en dash: nothing to show
  const double size = std::abs(value);
  if (size >= 1e9 || (size > 0 && size < 1e-4)) {
    char text[48];
    std::snprintf(text, sizeof text, "%.*g", digits, size);
    return (value < 0 ? kMinus : "") + std::string(text);
  }
  const int magnitude = size > 0 ? static_cast<int>(std::floor(std::log10(size))) : 0;
  return fixed_text(value, digits - 1 - magnitude);
}

std::string fixed_text(double value, int decimals) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", std::clamp(decimals, 0, kMostDecimals), std::abs(value));
  const bool zero = std::string_view(text).find_first_not_of("0.") == std::string_view::npos;
  return (value < 0 && !zero ? kMinus : "") + grouped(text);
}

std::string chance_text(double p) {
  return p < 0.001 ? "p &lt; 0.001" : "p = " + figure_text(p, 1);
}

}  // namespace driftwise::formats
