#include "server/core/text/quantity_text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace driftwise {
namespace {

// Of a value that is rounded: 42.3 -> 1, 0.574 -> -1.
int exponent_of(double rounded) {
  return static_cast<int>(std::floor(std::log10(std::abs(rounded)) + 1e-12));
}

double rounded_to(double value, int significant) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%.*e", significant - 1, value);
  return std::strtod(text.data(), nullptr);
}

}  // namespace

std::string digits_text(double value, int significant, bool sign) {
  if (!std::isfinite(value)) return "-";
  std::array<char, 64> text{};
  const char* rounded_format = sign ? "%+.*e" : "%.*e";
  std::snprintf(text.data(), text.size(), rounded_format, significant - 1, value);
  const double rounded = std::strtod(text.data(), nullptr);
  if (rounded == 0) return "0";
  const int exponent = exponent_of(rounded);
  if (exponent < -4 || exponent > 14) return text.data();
  const char* plain_format = sign ? "%+.*f" : "%.*f";
  std::snprintf(text.data(), text.size(), plain_format, std::max(0, significant - 1 - exponent),
                rounded);
  std::string digits = text.data();
  if (digits.find('.') != std::string::npos) {
    digits.erase(digits.find_last_not_of('0') + 1);
    if (digits.back() == '.') digits.pop_back();
  }
  return digits;
}

std::string mean_text(double mean, double a90) {
  constexpr int kSignificant = 3;
  const double beside = std::isfinite(a90) ? rounded_to(std::abs(a90), kSignificant) : 0;
  if (!std::isfinite(mean) || beside == 0) return digits_text(mean, kSignificant, true);
  const int last = exponent_of(beside) - (kSignificant - 1);
  const double steps = std::round(mean / std::pow(10, last));
  return digits_text(steps * std::pow(10, last), kSignificant, true);
}

SizeUnit size_unit(std::initializer_list<double> sizes, std::string_view unit) {
  if (unit != "nm") return {std::string(unit), 1};
  double largest = 0;
  for (const double size : sizes)
    if (std::isfinite(size)) largest = std::max(largest, std::abs(size));
  if (largest >= 999.5e3) return {"mm", 1e-6};
  if (largest >= 9999.5) return {"um", 1e-3};
  return {"nm", 1};
}

std::string quantity_text(double size, std::string_view unit, int significant) {
  const SizeUnit shown = size_unit({size}, unit);
  const std::string digits = digits_text(size * shown.factor, significant);
  return shown.unit == "1" ? digits : digits + " " + shown.unit;
}

}  // namespace driftwise
