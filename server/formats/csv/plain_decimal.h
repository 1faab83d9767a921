#pragma once
// Plain decimal numbers ("-20.4984542") of a table, to the same bits as std::from_chars and in half
// its time. Whatever is not plain, or too near to the middle between two doubles, is left to it.

#include <bit>
#include <cstdint>
#include <cstring>

namespace driftwise::formats {

namespace plain_decimal {

using Wide = unsigned __int128;

constexpr int kMostPlaces = 22;  // after the point
constexpr int kMostDigits = 19;  // 10^19 < 2^64

// 10^-k as quotient / 2^shift, cut off after the 128 bits that begin with the first one.
struct Reciprocal {
  std::uint64_t high = 0, low = 0;
  int shift = 0;
};

struct Tables {
  Reciprocal reciprocal[kMostPlaces + 1];
  double power[kMostPlaces + 1];  // exact
};

consteval Tables make_tables() {
  Tables tables{};
  Wide power = 1;
  for (int k = 0; k <= kMostPlaces; ++k, power *= 10) {
    Wide quotient = 0, rest = 1;
    int shift = 0;
    for (;; rest <<= 1, ++shift) {  // long division, a bit a turn
      quotient <<= 1;
      if (rest >= power) {
        rest -= power;
        quotient |= 1;
      }
      if ((quotient >> 127) != 0) break;
    }
    tables.reciprocal[k] = {static_cast<std::uint64_t>(quotient >> 64),
                            static_cast<std::uint64_t>(quotient), shift};
    tables.power[k] = static_cast<double>(power);
  }
  return tables;
}

inline constexpr Tables kTables = make_tables();

inline bool is_digit(char c) { return static_cast<unsigned char>(c - '0') < 10; }

inline std::uint64_t eight_at(const char* at) {
  std::uint64_t bytes = 0;
  std::memcpy(&bytes, at, sizeof bytes);
  return bytes;
}

// Of eight bytes in the order of memory, lowest first.
inline bool are_digits(std::uint64_t bytes) {
  return (((bytes + 0x4646464646464646) | (bytes - 0x3030303030303030)) & 0x8080808080808080) == 0;
}

// Pairs, then fours, then all eight, side by side in one register.
inline std::uint64_t number_of(std::uint64_t digits) {
  digits -= 0x3030303030303030;
  digits = digits * 10 + (digits >> 8);
  return (((digits & 0x000000FF000000FF) * 0x000F424000000064 +
           ((digits >> 16) & 0x000000FF000000FF) * 0x0000271000000001) >>
          32) &
         0xFFFFFFFF;
}

inline const char* take_digits(const char* at, const char* end, std::uint64_t& number) {
  if constexpr (std::endian::native == std::endian::little)
    for (; end - at >= 8 && are_digits(eight_at(at)); at += 8)
      number = number * 100'000'000 + number_of(eight_at(at));
  for (; at != end && is_digit(*at); ++at)
    number = number * 10 + static_cast<std::uint64_t>(*at - '0');
  return at;
}

// number / 10^places as the bits of the nearest double; false: too near to the middle of two.
inline bool nearest_bits(std::uint64_t number, int places, std::uint64_t& bits) {
  const Reciprocal& by = kTables.reciprocal[places];
  const int zeros = std::countl_zero(number);
  number <<= zeros;
  // The first 128 of 192 bits: what was cut off the quotient and here adds less than 2 to them.
  const Wide product = Wide{number} * by.high + ((Wide{number} * by.low) >> 64);
  const auto high = static_cast<std::uint64_t>(product >> 64);
  const auto low = static_cast<std::uint64_t>(product);
  const int top = static_cast<int>(high >> 63);
  const int dropped = 9 + top;  // 54 bits stay: the mantissa and the one that rounds
  const std::uint64_t mask = (std::uint64_t{1} << dropped) - 1;
  const std::uint64_t kept = high >> dropped;
  if ((high & mask) == mask && low >= ~std::uint64_t{1}) return false;  // 2 more might carry
  if ((high & mask) == 0 && low == 0 && (kept & 1) != 0)
    return false;  // the middle, or a bit above
  const int exponent = 129 - by.shift - zeros + dropped;
  bits = (static_cast<std::uint64_t>(exponent + 1074) << 52) + ((kept + 1) >> 1);
  return true;
}

}  // namespace plain_decimal

// Reads digits, a point and digits, with or without a minus and the point's part, up to the first
// byte that is no part of them. Returns where that is, or nullptr with value unchanged.
inline const char* read_plain_decimal(const char* at, const char* end, double& value) {
  using namespace plain_decimal;
  const bool negative = at != end && *at == '-';
  if (negative) ++at;
  std::uint64_t number = 0;
  const char* const first = at;
  at = take_digits(at, end, number);
  std::ptrdiff_t digits = at - first, places = 0;
  if (digits == 0) return nullptr;
  if (at != end && *at == '.') {
    const char* const point = at;
    at = take_digits(at + 1, end, number);
    places = at - point - 1;
    digits += places;
    if (places == 0) return nullptr;
  }
  if (digits > kMostDigits || places > kMostPlaces) return nullptr;
  if (at != end && (*at == 'e' || *at == 'E' || *at == '.')) return nullptr;
  if (number <= std::uint64_t{1} << 53) {  // number and power are exact: one rounding
    const double size = static_cast<double>(number) / kTables.power[places];
    value = negative ? -size : size;
    return at;
  }
  std::uint64_t bits = 0;
  if (!nearest_bits(number, static_cast<int>(places), bits)) return nullptr;
  value = std::bit_cast<double>(bits | (std::uint64_t{negative} << 63));
  return at;
}

}  // namespace driftwise::formats
