#include "server/formats/text/row_ranges.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <random>
#include <set>

namespace driftwise::formats {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(RowRanges, ReadWhatPeopleWrite) {
  EXPECT_THAT(*parse_row_ranges("12,40-45"), ElementsAre(12, 40, 41, 42, 43, 44, 45));
  EXPECT_THAT(*parse_row_ranges(" 7 , 3 - 4 ,7"), ElementsAre(3, 4, 7));
  EXPECT_THAT(*parse_row_ranges("0"), ElementsAre(0));
}

TEST(RowRanges, NameThePieceTheyCannotRead) {
  for (const char* bad : {"", ",", "1,,2", "a", "3-", "-3", "5-2", "1.5", "1-2-3",
                          "9999999999999999999", "0-1000000", "0-9223372036854775807"}) {
    const auto rows = parse_row_ranges(bad);
    ASSERT_FALSE(rows) << bad;
    EXPECT_EQ(rows.error().reason, "BAD_ROWS") << bad;
    EXPECT_THAT(rows.error().message, HasSubstr("expected")) << bad;
  }
}

TEST(RowRanges, ComeBackAsTheSameRows) {
  std::mt19937 random(5);
  for (int i = 0; i < 200; ++i) {
    std::set<std::int64_t> some;
    for (int k = 0; k < 40; ++k) some.insert(static_cast<std::int64_t>(random() % 60));
    const std::vector<std::int64_t> rows(some.begin(), some.end());
    EXPECT_EQ(*parse_row_ranges(row_ranges_text(rows)), rows);
  }
  EXPECT_EQ(row_ranges_text({}), "");
}

// Damaged text of every kind: refused or read, never more rows than promised.
TEST(RowRanges, StandAnything) {
  std::mt19937 random(11);
  const std::string alphabet = "0123456789,,-- .x\n";
  for (int i = 0; i < 5000; ++i) {
    std::string text;
    for (auto length = random() % 24; length > 0; --length)
      text += alphabet[random() % alphabet.size()];
    if (const auto rows = parse_row_ranges(text)) {
      EXPECT_TRUE(std::ranges::is_sorted(*rows));
      EXPECT_LE(rows->size(), kMostRows);
    }
  }
}

// Every second row of a run of 200 000 is 0.65 MB of numbers.
TEST(RowRanges, AreToldByTheFirstTen) {
  EXPECT_EQ(row_ranges_told({1, 3, 5, 6, 7}), "1,3,5-7");
  std::vector<std::int64_t> rows;
  for (std::int64_t row = 1; row < 200'000; row += 2) rows.push_back(row);
  EXPECT_EQ(row_ranges_told(rows), "1,3,5,7,9,11,13,15,17,19 and 99990 more (100000 rows)");
}

TEST(ExclusionsHash, SaysWhichRowsAndNothingElse) {
  Dataset data;
  data.rows = 4;
  EXPECT_EQ(exclusions_hash(data), "");
  data.excluded = {0, 0, 0, 0};
  EXPECT_EQ(exclusions_hash(data), "");
  data.excluded = {0, 1, 0, 0};
  const auto one = exclusions_hash(data);
  data.excluded = {0, 0, 1, 0};
  EXPECT_NE(exclusions_hash(data), one);
  data.time_s = {0, 1, 2, 3};
  data.excluded = {0, 1, 0, 0};
  EXPECT_EQ(exclusions_hash(data), one);
}

}  // namespace
}  // namespace driftwise::formats
