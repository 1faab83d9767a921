// The quick reader of plain decimals against std::from_chars, which the readers used alone before:
// the same end, the same bits, or no answer.
#include "server/formats/csv/plain_decimal.h"

#include <gtest/gtest.h>

#include <bit>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <random>
#include <string>

namespace driftwise::formats {
namespace {

struct Read {
  const char* end;
  std::uint64_t bits;
};

// True when it was read, false when it is left to std::from_chars.
bool agrees(const std::string& text) {
  double quick = 7, slow = 7;
  const char *begin = text.data(), *end = begin + text.size();
  const char* after = read_plain_decimal(begin, end, quick);
  if (!after) {
    EXPECT_EQ(quick, 7) << "'" << text << "': left, and changed all the same";
    return false;
  }
  const auto [place, code] = std::from_chars(begin, end, slow);
  EXPECT_TRUE(code == std::errc{} && after == place &&
              std::bit_cast<std::uint64_t>(quick) == std::bit_cast<std::uint64_t>(slow))
      << "'" << text << "': " << quick << " instead of " << slow;
  return true;
}

std::string shortest(double value) {
  char digits[64];
  return {digits, std::to_chars(digits, digits + sizeof digits, value).ptr};
}

double double_of(std::uint64_t fraction, int exponent) {
  return std::ldexp(1 + static_cast<double>(fraction >> 12) * 0x1p-52, exponent);
}

TEST(PlainDecimal, ReadsWhatInstrumentsWriteToTheBitsOfFromChars) {
  std::mt19937_64 random(20110722);
  int read = 0;
  constexpr int kNumbers = 300'000;
  for (int i = 0; i < kNumbers; ++i)
    read += agrees(shortest(double_of(random(), static_cast<int>(random() % 40) - 20)));
  EXPECT_GT(read, kNumbers * 2 / 3);  // the rest has an exponent, or its zeros make it too long
}

TEST(PlainDecimal, RoundsLikeFromCharsBesideTheMiddleOfTwoDoubles) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 100'000; ++i) {
    const double low = double_of(random(), static_cast<int>(random() % 14) - 8);
    const long double middle =
        (static_cast<long double>(low) + static_cast<long double>(std::nextafter(low, 1e9))) / 2;
    char digits[64];
    std::snprintf(digits, sizeof digits, "%.*Lf", static_cast<int>(random() % 14 + 6), middle);
    agrees(digits);
  }
}

TEST(PlainDecimal, TakesDigitsAnyWayTheyAreCut) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 300'000; ++i) {
    std::string text = random() % 4 == 0 ? "-" : "";
    for (std::size_t left = random() % 24; left > 0; --left)
      text += random() % 12 == 0 ? "."[0] : "000123456789"[random() % 12];
    constexpr const char* kTails[] = {"", ",1", "e5", "E", "x", " ", "\r\n", ".", "e-3,2"};
    agrees(text + kTails[random() % std::size(kTails)]);
  }
}

TEST(PlainDecimal, AgreesFromEveryByteOfTheFuzzCorpusAndTheDataSets) {
  for (const char* file :
       {"/fuzz/corpus/dataset_csv_fuzz/small.csv", "/fuzz/corpus/dataset_csv_fuzz/windows.csv",
        "/fuzz/corpus/dataset_csv_fuzz/remark_with_colons.csv",
        "/data/databases/version_1_cell_run_1.csv", "/data/standards/iso9283.csv",
        "/data/ur10_laser_tracker/series_a_subset.csv"}) {
    std::ifstream in(std::string(DRIFTWISE_SOURCE_DIR "/tests") + file, std::ios::binary);
    ASSERT_TRUE(in) << file;
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    for (std::size_t at = 0; at < text.size(); ++at) agrees(text.substr(at, 40));
  }
}

TEST(PlainDecimal, LeavesWhatIsNotPlain) {
  for (const char* text : {"", "-", ".", "-.5", ".5", "5.", "+1", "1e5", "1.5E3", "nan", "inf",
                           "12345678901234567890", "0.00000000000000000000001", "1.2.3"})
    EXPECT_FALSE(agrees(text)) << text;
}

}  // namespace
}  // namespace driftwise::formats
