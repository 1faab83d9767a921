#pragma once
// Small text helpers of the emulators. ASCII only: bytes above 0x7F are never letters, digits or
// blanks.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace driftwise::simulated {

constexpr bool is_blank(char c) { return c == ' ' || c == '\t'; }
constexpr bool is_digit(char c) { return c >= '0' && c <= '9'; }
constexpr bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
std::string upper(std::string_view text);
std::string_view trim(std::string_view text);  // blanks at both ends

std::vector<std::string_view> split_blanks(std::string_view text);
// Cuts at commas outside parentheses and quotes, trims each piece; empty text gives no piece.
std::vector<std::string> split_arguments(std::string_view text);

// A finite decimal number that fills the whole text ("+1.5E-3"); a leading '+' is allowed, hex,
// inf, nan are not.
std::optional<double> parse_number(std::string_view text);
std::optional<int> parse_integer(std::string_view text);
std::optional<unsigned> hex_number(std::string_view digits);

std::string shortest(double value);             // reads back exactly
std::string fixed(double value, int decimals);  // "0.1000000"
std::string scientific(double value);           // "+1.07794E+03" with eight decimals

}  // namespace driftwise::simulated
