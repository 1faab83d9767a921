#pragma once
// Checks of option values that CLI11 has too, with sentences a person can read.

#include <CLI/CLI.hpp>
#include <charconv>
#include <string>

namespace driftwise::cli {

// A number above 0: ids, counts, limits.
inline CLI::Validator positive_number() {
  return CLI::Validator(
      [](const std::string& text) -> std::string {
        double value = 0;
        const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (code == std::errc{} && end == text.data() + text.size() && value > 0) return {};
        return "found '" + text + "', expected a number above 0";
      },
      "POSITIVE");
}

}  // namespace driftwise::cli
