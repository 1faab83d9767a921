#include "server/core/cell_time.h"

#include <gtest/gtest.h>

namespace driftwise {
namespace {

TEST(CellTimeText, ReadsBackExactly) {
  for (const std::int64_t ns :
       {0LL, 1LL, 1795248299'123456789LL, 4102444800'000000000LL, 951782400'500000000LL}) {
    const auto again = parse_iso8601(to_iso8601({ns}));
    ASSERT_TRUE(again) << to_iso8601({ns});
    EXPECT_EQ(again->utc_ns, ns);
  }
}

TEST(CellTimeText, IsWhatDateWouldPrint) {
  EXPECT_EQ(to_iso8601({1795248299'500000000LL}),
            "2026-11-21T08:04:59.5Z");  // date -u -d @1795248299
}

class BadTime : public testing::TestWithParam<const char*> {};
TEST_P(BadTime, IsRefused) {
  const auto time = parse_iso8601(GetParam());
  ASSERT_FALSE(time);
  EXPECT_EQ(time.error().reason, "BAD_TIME");
}
INSTANTIATE_TEST_SUITE_P(Table, BadTime,
                         testing::Values("", "2026", "2026-11-21 08:04:59Z", "2026-13-21T08:04:59Z",
                                         "2026-02-30T08:04:59Z", "2026-11-21T24:04:59Z",
                                         "2026-11-21T08:04:59", "2026-11-21T08:04:59.Z",
                                         "2026-11-21T08:04:59.1234567890Z",
                                         "2026-11-21T08:04:59.-1Z", "9999-01-01T00:00:00Z"));

}  // namespace
}  // namespace driftwise
