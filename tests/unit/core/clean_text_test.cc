#include "server/core/text/clean_text.h"

#include <gtest/gtest.h>

#include "server/core/cell_time.h"

namespace driftwise {
namespace {

struct Case {
  const char* name;
  std::string text, line, lines;
};
class Clean : public testing::TestWithParam<Case> {};
TEST_P(Clean, LeavesNothingThatATerminalObeys) {
  EXPECT_EQ(clean_line(GetParam().text), GetParam().line);
  EXPECT_EQ(clean_text(GetParam().text), GetParam().lines);
  EXPECT_EQ(clean_line(clean_line(GetParam().text)), GetParam().line);
}
using namespace std::string_literals;
INSTANTIATE_TEST_SUITE_P(
    Table, Clean,
    testing::Values(Case{"Plain", "run 7, 0.5 mm", "run 7, 0.5 mm", "run 7, 0.5 mm"},
                    Case{"Umlaut", "J\xc3\xbcrg \xc2\xb5m \xe2\x82\xac \xf0\x9f\x94\xa7",
                         "J\xc3\xbcrg \xc2\xb5m \xe2\x82\xac \xf0\x9f\x94\xa7",
                         "J\xc3\xbcrg \xc2\xb5m \xe2\x82\xac \xf0\x9f\x94\xa7"},
                    Case{"ClearScreen", "a\x1b[2Jb", "a?[2Jb", "a?[2Jb"},
                    Case{"Title", "\x1b]0;pwned\x07x", "?]0;pwned?x", "?]0;pwned?x"},
                    Case{"LineFeed", "one\ntwo", "one two", "one\ntwo"},
                    Case{"Windows", "one\r\ntwo", "one  two", "one\r\ntwo"},
                    Case{"Return", "100 %\rfake", "100 % fake", "100 %?fake"},
                    Case{"Tab", "a\tb", "a b", "a\tb"}, Case{"Zero", "a\0b"s, "a?b", "a?b"},
                    Case{"Delete", "a\x7f", "a?", "a?"},
                    Case{"EightBitControl",
                         "a\xc2\x9b"
                         "2Jb",
                         "a?2Jb", "a?2Jb"},
                    Case{"LineSeparator",
                         "a\xe2\x80\xa8"
                         "b",
                         "a b", "a?b"},
                    Case{"RightToLeft",
                         "a\xe2\x80\xae"
                         "b",
                         "a?b", "a?b"},
                    Case{"Isolate",
                         "a\xe2\x81\xa6"
                         "b",
                         "a?b", "a?b"},
                    Case{"BadBytes",
                         "a\xff\xc3"
                         "b",
                         "a??b", "a??b"}),
    [](const auto& row) { return std::string(row.param.name); });

TEST(NanosecondsFromS, StayWithinWhatAnInstantCanBeMovedBy) {
  const CellTime now{1'795'248'000'000'000'000};
  for (const double seconds : {1e18, 1e300, std::numeric_limits<double>::infinity()}) {
    EXPECT_EQ(nanoseconds_from_s(seconds), nanoseconds_from_s(kLongest_s)) << seconds;
    EXPECT_EQ(nanoseconds_from_s(-seconds), -nanoseconds_from_s(kLongest_s)) << seconds;
    EXPECT_GT(now + nanoseconds_from_s(seconds), now) << seconds;
    EXPECT_LT(now - nanoseconds_from_s(seconds), now) << seconds;
  }
  EXPECT_EQ(nanoseconds_from_s(std::numeric_limits<double>::quiet_NaN()).count(), 0);
  EXPECT_EQ(nanoseconds_from_s(1.5).count(), 1'500'000'000);
  EXPECT_EQ(nanoseconds_from_s(-1.5).count(), -1'500'000'000);
}

}  // namespace
}  // namespace driftwise
