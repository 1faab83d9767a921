#pragma once
// Checks of option values that CLI11 has too, with sentences a person can read; and "nan" is no
// number here.

#include <CLI/CLI.hpp>
#include <charconv>
#include <functional>
#include <sstream>
#include <string>

namespace driftwise::cli {

// expected: "a number above 0"; name: what the help shows.
inline CLI::Validator number_that(std::function<bool(double)> good, std::string expected,
                                  std::string name) {
  return CLI::Validator(
      [good = std::move(good),
       expected = std::move(expected)](const std::string& text) -> std::string {
        double value = 0;
        const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (code == std::errc{} && end == text.data() + text.size() && good(value)) return {};
        return "found '" + text + "', expected " + expected;
      },
      std::move(name));
}

// A number above 0: ids, counts, limits.
inline CLI::Validator positive_number() {
  return number_that([](double value) { return value > 0 && value - value == 0; },
                     "a number above 0", "POSITIVE");
}

inline CLI::Validator number_from_zero() {
  return number_that([](double value) { return value >= 0 && value - value == 0; },
                     "a number from 0 up", "NONNEGATIVE");
}

inline CLI::Validator finite_number() {
  return number_that([](double value) { return value - value == 0; }, "a finite number", "FINITE");
}

inline CLI::Validator number_between(double low, double high) {
  std::ostringstream low_text, high_text;
  low_text << low;
  high_text.precision(10);
  high_text << high;
  return number_that([low, high](double value) { return value >= low && value <= high; },
                     "a number from " + low_text.str() + " to " + high_text.str(),
                     "in [" + low_text.str() + " - " + high_text.str() + "]");
}

}  // namespace driftwise::cli
