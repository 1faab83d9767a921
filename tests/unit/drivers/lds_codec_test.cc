#include "drivers/lds1000/lds_codec.h"

#include <gmock/gmock.h>

#include <random>

namespace driftwise::lds1000 {
namespace {

TEST(LdsValue, IsTheNumberAfterTheRepeatedCommand) {
  EXPECT_EQ(*parse_value("1TP-1596.3\r", 1), -1596.3);
  EXPECT_EQ(*parse_value("2TP258.1\r\n", 2), 258.1);
  EXPECT_EQ(*parse_value("1TP+0.02", 1), 0.02);
  for (const char* bad : {"", "1TP", "2TP1.0", "1TP12,2", "1TPnan", "1TPinf", "1TP1.0x", "TP1.0"})
    EXPECT_EQ(parse_value(bad, 1).error().reason, "BAD_REPLY") << bad;
}

struct SetUpReply {
  const char* name;
  const char* reply;
  Unit unit;
  double increment;
};
class LdsSetUp : public testing::TestWithParam<SetUpReply> {};
TEST_P(LdsSetUp, IsReadFromBothEnds) {
  const auto found = parse_set_up(GetParam().reply, 1);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->unit, GetParam().unit);
  EXPECT_EQ(found->increment, GetParam().increment);
}
INSTANTIATE_TEST_SUITE_P(
    Table, LdsSetUp,
    testing::Values(
        SetUpReply{"as_delivered", "1TA,RT,04512,1,\xB5rad,00102,00241\r", Unit::microradian, 1},
        SetUpReply{"in_a_dos_code_page", "1TA,RT,04512,1,\xE6rad,00102,00241", Unit::microradian,
                   1},
        SetUpReply{"through_a_utf8_server", "1TA,RT,04512,1,\xC2\xB5rad,00102,00241",
                   Unit::microradian, 1},
        SetUpReply{"seconds", "1TA,RT,04512,0.2,sec,00102,00241", Unit::arcsec, 0.2},
        SetUpReply{"decimal_comma", "1TA,RT,04512,0,2,sec,00102,00241", Unit::arcsec, 0.2}),
    [](const auto& row) { return std::string(row.param.name); });

TEST(LdsSetUp, IsRefusedInAnotherUnit) {
  EXPECT_EQ(parse_set_up("1TA,RT,04512,1,deg,00102,00241", 1).error().reason, "UNKNOWN_UNIT");
  for (const char* bad : {"", "1TA", "1TA,RT,1,sec,1,2", "2TA,RT,04512,1,sec,00102,00241",
                          "1TA,RT,04512,0,0,2,sec,00102,00241", "1TA,RT,04512,x,sec,00102,00241",
                          "1TA,RT,04512,-1,sec,00102,00241", "1TP12.2"})
    EXPECT_EQ(parse_set_up(bad, 1).error().reason, "BAD_REPLY") << bad;
}

TEST(LdsUnit, ConvertsMicroradian) {
  EXPECT_NEAR(arcsec_from(4.8481368, Unit::microradian), 1.0, 1e-7);  // 1 arcsec by definition
  EXPECT_EQ(arcsec_from(12.5, Unit::arcsec), 12.5);
}

TEST(LdsStatus, SaysWhetherTheSpotCanBeUsed) {
  EXPECT_TRUE(parse_status("MS@\r")->usable());
  EXPECT_TRUE(parse_status("MSH")->usable());  // acquiring
  EXPECT_TRUE(parse_status("MSA")->wrong_power);
  EXPECT_TRUE(parse_status("MSB")->wrong_position);
  EXPECT_FALSE(parse_status("MSC")->usable());
  for (const char* bad : {"", "MS", "MS@@", "MS0", "TS@"})
    EXPECT_EQ(parse_status(bad).error().reason, "BAD_REPLY") << bad;
}

TEST(LdsError, BecomesOurs) {
  EXPECT_TRUE(parse_error("TE@\r"));
  EXPECT_EQ(parse_error("TEA").error().reason, "UNKNOWN_COMMAND");
  EXPECT_EQ(parse_error("TEB").error().reason, "BAD_AXIS");
  EXPECT_EQ(parse_error("TEC").error().reason, "BAD_PARAMETER");
  EXPECT_EQ(parse_error("TED").error().reason, "NOT_NOW");
  EXPECT_EQ(parse_error("TES").error().code, ErrorCode::deadline_exceeded);
  EXPECT_EQ(parse_error("TEx").error().reason, "BAD_REPLY");
}

TEST(LdsReplies, SurviveAnythingOnTheLine) {
  std::mt19937 random(19980901);
  const std::string alphabet = "12TAPMSEXVI,.-+0459\xB5\xE6radsec\r\n @\0";
  for (int i = 0; i < 20'000; ++i) {
    std::string reply;
    for (auto n = random() % 40; n > 0; --n) reply += alphabet[random() % alphabet.size()];
    for (const int axis : {1, 2}) {
      EXPECT_TRUE(std::isfinite(parse_value(reply, axis).value_or(0)));
      EXPECT_GT(parse_set_up(reply, axis).value_or(lds1000::SetUp{Unit::arcsec, 1}).increment, 0);
    }
    (void)parse_status(reply);
    (void)parse_error(reply);
    (void)parse_version(reply);
    (void)parse_integration_ms(reply);
  }
}

}  // namespace
}  // namespace driftwise::lds1000
