#include "server/formats/import/number_style.h"

#include <gtest/gtest.h>

#include <charconv>
#include <cmath>
#include <random>
#include <string>

namespace driftwise::formats {
namespace {

constexpr NumberStyle kGerman{.decimal = ',', .thousands = '.'}, kPlain{};

TEST(NumberIn, ReadsDecimalCommasThousandsAndSigns) {
  EXPECT_EQ(number_in("1.234.567,5", kGerman), 1234567.5);
  EXPECT_EQ(number_in("-0,000212669", kGerman), -0.000212669);
  EXPECT_EQ(number_in("2,02103E+13", kGerman), 2.02103e13);
  EXPECT_EQ(number_in("+3", kPlain), 3.0);
  EXPECT_EQ(number_in(".5", kPlain), 0.5);
  EXPECT_EQ(number_in("5.", kPlain), 5.0);
  EXPECT_EQ(number_in("1'000.25", {.decimal = '.', .thousands = '\''}), 1000.25);
}

TEST(NumberIn, RefusesEverythingElse) {
  for (const char* text :
       {"",       "-",    "+",       ",",     "1,2,3", "1.2.3", "12.34,5", "1234.567,0",
        ".123,4", "1,5e", "1,5e+-3", "1 5",   "0x1F",  "nan",   "inf",     "-inf",
        "1e999",  "--1",  "1,-5",    "1,5mm", "e5",    "1..000"})
    EXPECT_FALSE(number_in(text, kGerman)) << text;
  EXPECT_FALSE(number_in("1,5", kPlain));
  EXPECT_FALSE(number_in("1e99999999999", kPlain));
}

TEST(NumberIn, MovesTheDecimalPointBeforeItRounds) {
  EXPECT_EQ(number_in("0,762898", kGerman, 3), 762.898);
  EXPECT_EQ(number_in("-0.084252400000001", kPlain, 3), -84.252400000001);
  EXPECT_EQ(number_in("1.5e-3", kPlain, 6), 1500.0);
  EXPECT_EQ(number_in("25.4", kPlain, -3), 0.0254);
}

// Every double, written in another style, is the same double again.
TEST(NumberIn, ReadsBackEveryDouble) {
  std::mt19937_64 random(2302);
  for (int i = 0; i < 20000; ++i) {
    const auto value = std::bit_cast<double>(random());
    if (!std::isfinite(value)) continue;
    char digits[64];
    const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
    std::string text(digits, end);
    if (const auto point = text.find('.'); point != std::string::npos) text[point] = ',';
    EXPECT_EQ(number_in(text, {.decimal = ','}), value) << text;
  }
}

}  // namespace
}  // namespace driftwise::formats
