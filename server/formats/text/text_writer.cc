#include "server/formats/text/text_writer.h"

#include <bit>
#include <charconv>
#include <cmath>
#include <limits>

namespace driftwise::formats {
namespace {

constexpr std::size_t kLongestNumber = 32;
constexpr std::array<std::uint64_t, 5> kPowersOfTen = {1, 10, 100, 1000, 10'000};
constexpr int kMantissaBits = std::numeric_limits<double>::digits - 1;  // as stored
constexpr int kExponentBias = 1075;                                     // of a whole mantissa

// |value| 10^decimals rounded half to even, where integers of 128 bits hold it: below 2^33.
struct Scaled {
  bool fits;
  std::uint64_t digits;
};
Scaled scaled(std::uint64_t bits, int decimals) {
  const auto exponent = static_cast<int>(bits >> kMantissaBits & 0x7ff);
  const std::uint64_t fraction = bits & ((std::uint64_t{1} << kMantissaBits) - 1);
  const std::uint64_t mantissa =
      exponent == 0 ? fraction : fraction | std::uint64_t{1} << kMantissaBits;
  // The value is mantissa 2^-shift.
  const int shift = kExponentBias - (exponent == 0 ? 1 : exponent);
  if (shift < 20) return {false, 0};
  // The product is below 2^67: behind a larger shift it is less than half.
  if (shift > 67) return {true, 0};
  __extension__ typedef unsigned __int128 Wide;
  const Wide product =
      static_cast<Wide>(mantissa) * kPowersOfTen[static_cast<std::size_t>(decimals)];
  const Wide half = static_cast<Wide>(1) << (shift - 1);
  const Wide rest = product & (2 * half - 1);
  auto digits = static_cast<std::uint64_t>(product >> shift);
  if (rest > half || (rest == half && (digits & 1) != 0)) ++digits;
  return {true, digits};
}

}  // namespace

TextWriter& TextWriter::operator<<(double value) {
  if (!std::isfinite(value)) return *this;
  make_room(kLongestNumber);
  at_ = std::to_chars(at_, at_ + kLongestNumber, value).ptr;
  return *this;
}

TextWriter& TextWriter::operator<<(std::int64_t value) {
  make_room(kLongestNumber);
  at_ = std::to_chars(at_, at_ + kLongestNumber, value).ptr;
  return *this;
}

TextWriter& TextWriter::fixed(double value, int decimals) {
  const auto bits = std::bit_cast<std::uint64_t>(value);
  const Scaled number = scaled(bits, decimals);
  if (!number.fits) {
    make_room(64);
    const auto [end, code] =
        std::to_chars(at_, at_ + 64, value, std::chars_format::fixed, decimals);
    if (code != std::errc{}) return *this << value;  // too many digits for a line
    at_ = end;
    return *this;
  }
  make_room(kLongestNumber);
  if (bits >> 63 != 0) *at_++ = '-';
  const std::uint64_t power = kPowersOfTen[static_cast<std::size_t>(decimals)];
  at_ = std::to_chars(at_, at_ + kLongestNumber, number.digits / power).ptr;
  *at_++ = '.';
  std::uint64_t rest = number.digits % power;
  for (char* digit = at_ + decimals; digit != at_; rest /= 10)
    *--digit = static_cast<char>('0' + rest % 10);
  at_ += decimals;
  return *this;
}

}  // namespace driftwise::formats
