#include "drivers/touch_probe/nd28x_codec.h"

#include <gmock/gmock.h>

namespace driftwise::touch_probe {
namespace {

using testing::HasSubstr;

TEST(Nd28xValue, IsASignAndMillimetres) {
  EXPECT_DOUBLE_EQ(parse_value("+    1.23450 \r\n").value(), 1.2345);
  EXPECT_DOUBLE_EQ(parse_value("-  345.67890 \r\n").value(), -345.6789);
  EXPECT_DOUBLE_EQ(parse_value("+0.00005\r\n").value(), 5e-5);
}

TEST(Nd28xValue, IsReadBehindTheStartOfText) {
  EXPECT_DOUBLE_EQ(parse_value("\x02-3.20000\r\n").value(), -3.2);
}

TEST(Nd28xValue, InInchesIsAWrongSetUp) {
  const auto value = parse_value("+    0.12345\"\r\n");
  ASSERT_FALSE(value);
  EXPECT_EQ(value.error().reason, "WRONG_SET_UP");
  EXPECT_THAT(value.error().message, HasSubstr("millimetres"));
}

TEST(Nd28xValue, IsNotTheMessageThatTheReadOutShows) {
  const auto value = parse_value("SIGNAL X\r\n");
  ASSERT_FALSE(value);
  EXPECT_EQ(value.error().reason, "INPUT_ERROR");
  EXPECT_THAT(value.error().message, HasSubstr("SIGNAL X"));
}

struct BadValue {
  const char* name;
  const char* reply;
};
class Nd28xNonsense : public testing::TestWithParam<BadValue> {};
TEST_P(Nd28xNonsense, IsRefused) {
  const auto value = parse_value(GetParam().reply);
  ASSERT_FALSE(value);
  EXPECT_EQ(value.error().reason, "BAD_REPLY");
}
INSTANTIATE_TEST_SUITE_P(
    Table, Nd28xNonsense,
    testing::Values(BadValue{"Nothing", ""}, BadValue{"NoSign", "1.2345\r\n"},
                    BadValue{"TwoSigns", "+-1.2\r\n"}, BadValue{"SignAlone", "+ \r\n"},
                    BadValue{"NotFinite", "+nan\r\n"}, BadValue{"TooLong", "+1234.5\r\n"},
                    BadValue{"TwoNumbers", "+1.2 3.4\r\n"}, BadValue{"NotAcknowledged", "\x15"}),
    [](const auto& row) { return std::string(row.param.name); });

TEST(Nd28xIdentity, IsThreeLinesBehindTheStartOfText) {
  const auto identity = parse_identity("\x02ND 287    \r\n349797-05 \r\nV1.02     \r\n");
  ASSERT_TRUE(identity) << identity.error().message;
  EXPECT_EQ(*identity, "ND 287, 349797-05, V1.02");
  EXPECT_EQ(parse_identity("ND 287\r\n349797-05\r\nV1.02\r\n").error().reason, "BAD_REPLY");
  EXPECT_EQ(parse_identity("\x02ND 287\r\n").error().reason, "BAD_REPLY");
  EXPECT_EQ(parse_identity("\x02"
                           "DPL2\r\nSN:1\r\nV1\r\n")
                .error()
                .reason,
            "WRONG_DEVICE");
}

}  // namespace
}  // namespace driftwise::touch_probe
