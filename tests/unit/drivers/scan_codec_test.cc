#include "drivers/keithley_2701/scan_codec.h"

#include <gmock/gmock.h>

#include "server/core/data/reading.h"

namespace driftwise::keithley {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(ChannelList, WritesRunsShort) {
  EXPECT_EQ(encode_channel_list(std::vector{101, 102, 103, 104}), "(@101:104)");
  EXPECT_EQ(encode_channel_list(std::vector{101, 103, 201, 202}), "(@101,103,201,202)");
  EXPECT_EQ(encode_channel_list(std::vector{105}), "(@105)");
}

TEST(ChannelList, ReadsListsAndRanges) {
  EXPECT_THAT(*parse_channel_list("(@101,103,201:203)\n"), ElementsAre(101, 103, 201, 202, 203));
  EXPECT_THAT(*parse_channel_list("(@)"), ElementsAre());
  for (const char* bad : {"", "101:110", "(@101:", "(@101-103)", "(@103:101)", "(@1)", "(@101,)x",
                          "(@101:99999)", "(@a)"})
    EXPECT_FALSE(parse_channel_list(bad)) << bad;
}

TEST(ErrorQueue, IsANumberAndAText) {
  EXPECT_EQ(parse_device_error("0,\"No error\"\n")->number, 0);
  EXPECT_EQ(parse_device_error("+0")->number, 0);
  const auto error = parse_device_error("-113,\"Undefined header\"");
  EXPECT_EQ(error->number, -113);
  EXPECT_EQ(error->text, "Undefined header");
  for (const char* bad : {"", "No error", "1.5,\"x\"", ",\"x\""})
    EXPECT_FALSE(parse_device_error(bad)) << bad;
}

TEST(ScanFields, MayCarryTheirUnits) {
  EXPECT_THAT(*parse_fields("+1.07790E+03OHM4W,101,+11.664SECS\r", 3),
              ElementsAre(1077.9, 101, 11.664));
}

struct Bad {
  const char *name, *reply, *reason;
};
class BadScan : public testing::TestWithParam<Bad> {};
TEST_P(BadScan, IsDataLoss) {
  const auto fields = parse_fields(GetParam().reply, 6);
  ASSERT_FALSE(fields);
  EXPECT_EQ(fields.error().code, ErrorCode::data_loss);
  EXPECT_EQ(fields.error().reason, GetParam().reason);
}
INSTANTIATE_TEST_SUITE_P(
    Table, BadScan,
    testing::Values(Bad{"empty", "", "FIELD_COUNT"}, Bad{"short", "1,101,0.1,1,102", "FIELD_COUNT"},
                    Bad{"long", "1,101,0,1,102,0,1", "FIELD_COUNT"},
                    Bad{"two_scans_merged", "1,101,0,1,102,0;1,101,0,1,102,0", "BAD_REPLY"},
                    Bad{"hole", "1,101,,1,102,0", "BAD_REPLY"},
                    Bad{"comma_at_the_end", "1,101,0,1,102,", "BAD_REPLY"},
                    Bad{"text", "1,101,0,abc,102,0", "BAD_REPLY"},
                    Bad{"not_a_number", "nan,101,0,1,102,0", "BAD_REPLY"},
                    Bad{"not_ascii", "1,101,0\xb5,1,102,0", "BAD_REPLY"}),
    [](const auto& row) { return std::string(row.param.name); });

const std::vector<int> kTwo{101, 102};

TEST(ScanLayout, IsLearntFromTheChannelNumbers) {
  EXPECT_EQ(*learn_layout(std::vector<double>{1077, 101, 0.1, 1078, 102, 0.6}, kTwo),
            (Layout{3, 0, 1, 2}));
  EXPECT_EQ(*learn_layout(std::vector<double>{1077, 0.1, 101, 1078, 0.6, 102}, kTwo),
            (Layout{3, 0, 2, 1}));
  EXPECT_EQ(*learn_layout(std::vector<double>{101, 1077, 0.1, 102, 1078, 0.6}, kTwo),
            (Layout{3, 1, 0, 2}));
}

TEST(ScanLayout, IsNotGuessed) {
  EXPECT_EQ(learn_layout(std::vector<double>{1077, 101, 0.1, 1078, 103, 0.6}, kTwo).error().reason,
            "UNKNOWN_LAYOUT");
  EXPECT_EQ(learn_layout(std::vector<double>{1077, 101, 101, 1078, 102, 102}, kTwo).error().reason,
            "UNKNOWN_LAYOUT");
}

TEST(Scan, KeepsTheOrderOfTheWireAndMarksOverflows) {
  const auto scan =
      read_scan(std::vector<double>{9.9e37, 102, 0.1, 1077, 101, 0.6}, Layout{}, kTwo);
  ASSERT_TRUE(scan);
  EXPECT_EQ((*scan)[0].channel, 102);
  EXPECT_TRUE(is_missing((*scan)[0].value));
  EXPECT_EQ((*scan)[1].value, 1077);
  EXPECT_EQ((*scan)[1].time_s, 0.6);
}

TEST(Scan, RefusesAChannelItDidNotAskFor) {
  EXPECT_EQ(read_scan(std::vector<double>{1, 101, 0, 1, 101, 0}, Layout{}, kTwo).error().reason,
            "WRONG_CHANNEL");
  EXPECT_EQ(read_scan(std::vector<double>{1, 101, 0}, Layout{}, kTwo).error().reason,
            "FIELD_COUNT");
}

}  // namespace
}  // namespace driftwise::keithley
