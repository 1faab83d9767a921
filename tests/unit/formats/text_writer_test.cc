// TextWriter against std::to_chars, whose digits it has to give.

#include "server/formats/text/text_writer.h"

#include <gtest/gtest.h>

#include <bit>
#include <charconv>
#include <cmath>
#include <limits>
#include <random>

namespace driftwise::formats {
namespace {

std::string written(double value, int decimals) {
  std::string out;
  TextWriter(out).fixed(value, decimals);
  return out;
}

std::string standard(double value, int decimals) {
  char digits[400];
  const auto end =
      std::to_chars(digits, digits + sizeof digits, value, std::chars_format::fixed, decimals).ptr;
  return {digits, end};
}

TEST(TextWriter, RoundsFixedDecimalsAsTheStandardLibrary) {
  std::mt19937_64 random(20261126);
  std::uniform_real_distribution<double> exponent(-40, 33);
  for (int i = 0; i < 200'000; ++i) {
    const double size = std::exp2(exponent(random));
    const double value = std::copysign(size, i % 2 == 0 ? 1.0 : -1.0);
    for (int decimals = 1; decimals <= 4; ++decimals)
      ASSERT_EQ(written(value, decimals), standard(value, decimals))
          << std::hexfloat << value << " with " << decimals;
  }
}

TEST(TextWriter, RoundsWhatLiesHalfwayToTheEvenDigit) {
  EXPECT_EQ(written(0.125, 2), "0.12");
  EXPECT_EQ(written(0.375, 2), "0.38");
  EXPECT_EQ(written(2.5 / 1000, 2), "0.00");  // a little more than 0.0025, which is less than half
  for (int eighths = 0; eighths < 4000; ++eighths)  // every other third decimal is a half
    for (int decimals = 1; decimals <= 3; ++decimals)
      ASSERT_EQ(written(eighths / 16.0, decimals), standard(eighths / 16.0, decimals));
}

TEST(TextWriter, WritesTheEndsOfTheRangeAsTheStandardLibrary) {
  constexpr double kLimit = 8589934592.0;  // 2^33: above it std::to_chars itself is asked
  for (const double value :
       {0.0, -0.0, std::numeric_limits<double>::denorm_min(), std::numeric_limits<double>::min(),
        std::nextafter(kLimit, 0), kLimit, 1e15, 0.5e-4, std::nextafter(0.5e-4, 0), 0.99995,
        std::nextafter(0.99995, 1)})
    for (int decimals = 1; decimals <= 4; ++decimals) {
      EXPECT_EQ(written(value, decimals), standard(value, decimals)) << value;
      EXPECT_EQ(written(-value, decimals), standard(-value, decimals)) << -value;
    }
}

TEST(TextWriter, WritesAnyBitPatternAsTheStandardLibrary) {
  std::mt19937_64 random(7);
  for (int i = 0; i < 200'000; ++i) {
    const auto value = std::bit_cast<double>(random());
    if (!(std::abs(value) < 1e40)) continue;  // longer than a line's number
    ASSERT_EQ(written(value, 2), standard(value, 2)) << std::hexfloat << value;
  }
}

TEST(TextWriter, KeepsTheOrderOfShortAndLongPieces) {
  std::string out = "before ";
  const std::string longer(3000, 'x');
  {
    TextWriter text(out);
    text << "a" << std::string_view(longer) << " " << 1.5 << std::int64_t{-7};
    for (int i = 0; i < 500; ++i) text << "," << 0.1;
  }
  std::string expected = "before a" + longer + " 1.5-7";
  for (int i = 0; i < 500; ++i) expected += ",0.1";
  EXPECT_EQ(out, expected);
}

TEST(TextWriter, WritesNothingForWhatIsNoNumber) {
  std::string out;
  TextWriter(out) << std::numeric_limits<double>::quiet_NaN()
                  << std::numeric_limits<double>::infinity();
  EXPECT_EQ(out, "");
}

}  // namespace
}  // namespace driftwise::formats
