// Tables that are no measurements: refused before they cost time or memory.

#include <gtest/gtest.h>

#include <cmath>

#include "server/formats/csv/dataset_csv.h"
#include "server/formats/csv/trajectory_csv.h"

namespace driftwise::formats {
namespace {

std::string header_of(std::size_t columns) {
  std::string text = "time_s";
  for (std::size_t i = 1; i < columns; ++i) text += ",c" + std::to_string(i) + "_mm";
  return text + "\n";
}

struct Case {
  const char* name;
  std::string text;
  const char* reason;
};
class HostileTable : public testing::TestWithParam<Case> {};
TEST_P(HostileTable, IsRefusedByTheLimitItBreaks) {
  const auto data = read_dataset_csv(GetParam().text, "hostile.csv", {}, kRequestLimits);
  ASSERT_FALSE(data);
  EXPECT_EQ(data.error().reason, GetParam().reason);
  EXPECT_LT(data.error().message.size(), 400U);
  EXPECT_TRUE(data.error().message.starts_with("hostile.csv:")) << data.error().message;
  EXPECT_EQ(data.error().message.find_first_of("\x1b\r\n"), std::string::npos);
}
INSTANTIATE_TEST_SUITE_P(
    Table, HostileTable,
    testing::Values(
        Case{"Columns60000", header_of(60'000) + "0\n", "TOO_MANY_COLUMNS"},
        Case{"Columns300000", header_of(300'000), "TOO_MANY_COLUMNS"},
        Case{"Commas", std::string(1 << 20, ','), "NO_HEADER"},
        Case{"LongName", "time_s," + std::string(100'000, 'x') + "_mm\n", "NAME_TOO_LONG"},
        Case{"NoLineEnd", std::string(3 << 20, 'x'), "HEADER_TOO_LONG"},
        Case{"Zeros", std::string(3 << 20, '\0'), "NOT_TEXT"},
        Case{"Escapes", "time_s,\x1b[2Jq1_mm\n", "BAD_CHANNEL"},
        Case{"EightBitEscapes",
             "time_s,\xc2\x9b"
             "2Jq1_mm\n",
             "BAD_CHANNEL"},
        Case{"Metadata",
             [] {
               std::string text;
               for (int i = 0; i < 20'000; ++i) text += "#\n";
               return text + "time_s\n1\n";
             }(),
             "TOO_MUCH_METADATA"},
        Case{"Values", "x_mm\n" + std::string(std::size_t{9} << 20, '\n'), "TOO_MANY_VALUES"}),
    [](const auto& row) { return std::string(row.param.name); });

TEST(WideTable, OfAllColumnsThatAreAllowedIsRead) {
  const std::size_t columns = CsvLimits{}.columns;
  std::string row = "1";
  for (std::size_t i = 1; i < columns; ++i) row += ",0.5";
  const auto data = read_dataset_csv(header_of(columns) + row + "\n", "wide.csv");
  ASSERT_TRUE(data) << data.error().message;
  EXPECT_EQ(data->columns.size(), columns - 1);
}

TEST(Metadata, IsCleaned) {
  const auto data = read_dataset_csv(
      "# cell: a\x1b]0;x\x07"
      "b\n# note \x1b[31m\ntime_s\n1\n",
      "d.csv");
  ASSERT_TRUE(data) << data.error().message;
  EXPECT_EQ(data->metadata[0].second, "a?]0;x?b");
  EXPECT_EQ(data->metadata[1].second, "note ?[31m");
}

TEST(Trajectory, BoundsTheDwell) {
  const auto plan = read_trajectory_csv("q1_mm,dwell_s\n0,1e18\n", "plan.csv");
  ASSERT_FALSE(plan);
  EXPECT_EQ(plan.error().reason, "BAD_DWELL");
  EXPECT_EQ(plan.error().message,
            "plan.csv:2: column dwell_s: found 1e+18, expected 0 to 604800 s (a week)");
  EXPECT_TRUE(read_trajectory_csv("q1_mm,dwell_s\n0,604800\n", "plan.csv"));
}

TEST(Trajectory, BoundsTheRows) {
  std::string text = "q1_mm\n";
  for (std::size_t i = 0; i <= kMostTrajectoryRows; ++i) text += "0\n";
  EXPECT_EQ(read_trajectory_csv(text, "plan.csv").error().reason, "TOO_MANY_ROWS");
}

}  // namespace
}  // namespace driftwise::formats
