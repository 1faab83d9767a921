#include "server/formats/import/time_format.h"

#include <gtest/gtest.h>

namespace driftwise::formats {
namespace {

struct TimeCase {
  const char* name;
  const char* format;
  double utc_offset_h;
  const char* text;
  const char* instant;
};
class ForeignTime : public testing::TestWithParam<TimeCase> {};
TEST_P(ForeignTime, IsTheInstantItMeans) {
  const auto format = TimeFormat::parse(GetParam().format, GetParam().utc_offset_h);
  ASSERT_TRUE(format) << format.error().message;
  const auto time = format->read(GetParam().text, '.');
  ASSERT_TRUE(time) << time.error().message;
  EXPECT_EQ(to_iso8601(*time), GetParam().instant);
}
INSTANTIATE_TEST_SUITE_P(
    Table, ForeignTime,
    testing::Values(
        TimeCase{"Iso", "iso8601", 0, "2026-11-21T08:04:59Z", "2026-11-21T08:04:59Z"},
        TimeCase{"IsoOffset", "iso8601", 0, "2026-11-21T08:04:59.5+02:00",
                 "2026-11-21T06:04:59.5Z"},
        TimeCase{"IsoShortOffset", "iso8601", 0, "2026-11-21 08:04:59-0530",
                 "2026-11-21T13:34:59Z"},
        TimeCase{"IsoLocal", "iso8601", 2, "2026-11-21 08:04", "2026-11-21T06:04:00Z"},
        TimeCase{"IsoComma", "iso8601", 0, "2026-11-21T08:04:59,000000001Z",
                 "2026-11-21T08:04:59.000000001Z"},
        TimeCase{"Tracker", "%Y%m%d%H%M%S", 2, "20200714163904", "2020-07-14T14:39:04Z"},
        TimeCase{"American", "%m/%d/%Y %I:%M:%S %p", 0, "7/4/2026 12:30:00 AM",
                 "2026-07-04T00:30:00Z"},
        TimeCase{"AmericanNoon", "%m/%d/%y %I:%M %p", 0, "7/4/26 12:30 pm", "2026-07-04T12:30:00Z"},
        TimeCase{"MonthName", "%d-%b-%Y %H:%M:%S.%f", 0, "03-Mar-2026 01:02:03.25",
                 "2026-03-03T01:02:03.25Z"},
        TimeCase{"Percent", "%%%Y-%m-%d", 0, "%2026-01-02", "2026-01-02T00:00:00Z"},
        TimeCase{"Unix", "unix_s", 0, "1595515144.25", "2020-07-23T14:39:04.25Z"},
        TimeCase{"UnixMs", "unix_ms", 0, "1595515144250", "2020-07-23T14:39:04.25Z"},
        TimeCase{"UnixNs", "unix_ns", 0, "1595515144250000100", "2020-07-23T14:39:04.2500001Z"},
        TimeCase{"UnixNsOdd", "unix_ns", 0, "1595515144250000001",
                 "2020-07-23T14:39:04.250000001Z"},
        TimeCase{"UnixNsBefore", "unix_ns", 0, "-1", "1969-12-31T23:59:59.999999999Z"},
        // 2020-01-01 is day 43831 of Excel's calendar; 3660681600 s after 1904.
        TimeCase{"Excel", "excel_days", 1, "43831.5", "2020-01-01T11:00:00Z"},
        TimeCase{"LabView", "labview_s", 0, "3660681600", "2020-01-01T00:00:00Z"},
        TimeCase{"Elapsed", "minutes", 0, "1.5", "1970-01-01T00:01:30Z"}),
    [](const auto& row) { return std::string(row.param.name); });

TEST(TimeFormat, RefusesPatternsThatSayNoDay) {
  for (const char* format :
       {"", "%H:%M", "%Y-%m", "%Y-%m-%d %", "%Y-%m-%d %Q", "%Y-%m-%d %I", "%Y-%Y-%m-%d", "unix"})
    EXPECT_EQ(TimeFormat::parse(format, 0).error().reason, "BAD_TIME_FORMAT") << format;
}

TEST(TimeFormat, RefusesTimesThatAreNone) {
  for (const char* text :
       {"", "2026-13-01T00:00:00Z", "2026-02-29T00:00:00Z", "2026-01-01T24:00:00Z",
        "2026-01-01T00:00:00.", "26-01-01T00:00:00Z", "2026-01-01T00:00:00+",
        "2026-01-01T00:00:00Zx", "1600-01-01T00:00:00Z", "2026-01-01T00:00:00+99:00"})
    EXPECT_EQ(TimeFormat::parse("iso8601", 0)->read(text, '.').error().reason, "BAD_TIME") << text;
  const auto pattern = TimeFormat::parse("%d.%m.%Y", 0);
  EXPECT_FALSE(pattern->read("31.04.2026", '.'));
  EXPECT_FALSE(pattern->read("1.4.2026 ", '.'));
  EXPECT_FALSE(TimeFormat::parse("unix_ns", 0)->read("1e30", '.'));
  EXPECT_FALSE(TimeFormat::parse("hours", 0)->read("1,5", '.'));
  EXPECT_TRUE(TimeFormat::parse("hours", 0)->read("1,5", ','));
}

}  // namespace
}  // namespace driftwise::formats
