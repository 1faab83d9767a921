#include "drivers/inclinometer/dpl_codec.h"

#include <gmock/gmock.h>

namespace driftwise::inclinometer {
namespace {

using testing::HasSubstr;

TEST(DplTilt, IsTwoLinesInDegrees) {
  const auto tilt = parse_tilt("X=+01.234\r\nY=-00.007\r\n");
  ASSERT_TRUE(tilt) << tilt.error().message;
  EXPECT_DOUBLE_EQ(tilt->x_deg, 1.234);
  EXPECT_DOUBLE_EQ(tilt->y_deg, -0.007);
}

TEST(DplTilt, IsReadBehindTheEchoOfTheStop) {
  EXPECT_TRUE(parse_tilt("sX=+01.234\r\nY=-00.007\r\n"));
  EXPECT_TRUE(parse_tilt("s\r\nX=+01.234\r\nY=-00.007\r\n"));
}

struct BadTilt {
  const char* name;
  const char* reply;
};
class DplNonsense : public testing::TestWithParam<BadTilt> {};
TEST_P(DplNonsense, IsRefused) {
  const auto tilt = parse_tilt(GetParam().reply);
  ASSERT_FALSE(tilt);
  EXPECT_EQ(tilt.error().reason, "BAD_REPLY");
  EXPECT_THAT(tilt.error().message, HasSubstr("X=<degrees>"));
}
INSTANTIATE_TEST_SUITE_P(Table, DplNonsense,
                         testing::Values(BadTilt{"Nothing", ""},
                                         BadTilt{"OneLine", "X=+01.234\r\n"},
                                         BadTilt{"Swapped", "Y=+01.234\r\nX=-00.007\r\n"},
                                         BadTilt{"NoNumber", "X=+01.2a4\r\nY=-00.007\r\n"},
                                         BadTilt{"TwoSigns", "X=++1.234\r\nY=-00.007\r\n"},
                                         BadTilt{"NotFinite", "X=nan\r\nY=-00.007\r\n"},
                                         BadTilt{"TooLarge", "X=+999.000\r\nY=-00.007\r\n"},
                                         BadTilt{"ThreeLines", "X=+0.1\r\nY=+0.1\r\nX=+0.1\r\n"}),
                         [](const auto& row) { return std::string(row.param.name); });

TEST(DplIdentity, IsModelVersionAndSerialNumber) {
  const auto identity = parse_identity("sDPL2 V1.8.0\r\nSN:12345678\r\n");
  ASSERT_TRUE(identity) << identity.error().message;
  EXPECT_EQ(*identity, "DPL2 V1.8.0, SN:12345678");
  EXPECT_EQ(parse_identity("KEITHLEY\r\nSN:1\r\n").error().reason, "WRONG_DEVICE");
  EXPECT_EQ(parse_identity("X=+01.234\r\nY=-00.007\r\n").error().reason, "BAD_REPLY");
  EXPECT_TRUE(ends_identity("SN:12345678"));
  EXPECT_FALSE(ends_identity("DPL2 V1.8.0"));
}

}  // namespace
}  // namespace driftwise::inclinometer
