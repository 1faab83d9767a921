#include "drivers/pi_gcs/gcs_codec.h"

#include <gmock/gmock.h>

#include "drivers/pi_gcs/start_trap.h"

namespace driftwise::gcs {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::vector<std::string> kX{"X"}, kXY{"X", "Y"};

TEST(GcsCommands, AreOneLineWithAllAxes) {
  EXPECT_EQ(encode_move(kXY, std::vector{1.5, -0.25}), "MOV X 1.5 Y -0.25\n");
  EXPECT_EQ(encode_move(kX, std::vector{0.1}), "MOV X 0.1\n");  // shortest text that reads back
  EXPECT_EQ(encode_command("FRF", kXY), "FRF X Y\n");
  EXPECT_EQ(encode_switch("SVO", kXY, 1), "SVO X 1 Y 1\n");
}

TEST(GcsPositions, AreFoundByName) {
  EXPECT_THAT(*parse_axis_values("X=0.1000000 \nY=-2\n", kXY), ElementsAre(0.1, -2));
  EXPECT_THAT(*parse_axis_values("Y=-2 \nX=1e-3\n", kXY), ElementsAre(0.001, -2));
  EXPECT_THAT(*parse_axis_values("U=7 \nX= +3\n", kX), ElementsAre(3))
      << "further axes are passed over";
  EXPECT_THAT(*parse_axis_values("X=1\r\n", kX), ElementsAre(1));
}

struct Bad {
  const char *name, *reply, *says;
};
class BadPositions : public testing::TestWithParam<Bad> {};
TEST_P(BadPositions, AreDataLoss) {
  const auto values = parse_axis_values(GetParam().reply, kXY);
  ASSERT_FALSE(values);
  EXPECT_EQ(values.error().code, ErrorCode::data_loss);
  EXPECT_THAT(values.error().message, HasSubstr(GetParam().says));
}
INSTANTIATE_TEST_SUITE_P(Table, BadPositions,
                         testing::Values(Bad{"empty", "", "axis X"},
                                         Bad{"one_missing", "X=1\n", "axis Y"},
                                         Bad{"wrong_axis", "X=1 \nZ=2\n", "axis Y"},
                                         Bad{"twice", "X=1 \nX=2\n", "twice"},
                                         Bad{"no_equals", "1.5\n", "<axis>=<number>"},
                                         Bad{"no_number", "X= \nY=2\n", "<axis>=<number>"},
                                         Bad{"two_numbers", "X=1 2 \nY=2\n", "<axis>=<number>"},
                                         Bad{"comma", "X=1,5 \nY=2\n", "<axis>=<number>"},
                                         Bad{"infinite", "X=inf \nY=2\n", "<axis>=<number>"},
                                         Bad{"not_ascii", "X=\xb5 \nY=2\n", "<axis>=<number>"}),
                         [](const auto& row) { return std::string(row.param.name); });

TEST(GcsFlags, AreZeroOrOne) {
  EXPECT_THAT(*parse_axis_flags("X=1 \nY=0\n", kXY), ElementsAre(true, false));
  EXPECT_FALSE(parse_axis_flags("X=2 \nY=0\n", kXY));
}

TEST(GcsMask, IsHexadecimal) {
  EXPECT_EQ(*parse_hex("0\n"), 0u);
  EXPECT_EQ(*parse_hex("A\n"), 10u);
  EXPECT_EQ(*parse_hex("0x10000\n"), kStatusReferenced);
  for (const char* bad : {"", "\n", "X=1\n", "-1\n", "1 2\n", "0x\n", "11111111111111111\n"})
    EXPECT_FALSE(parse_hex(bad)) << bad;
}

TEST(GcsErrorNumber, IsOneInteger) {
  EXPECT_EQ(*parse_error_number("0\n"), 0);
  EXPECT_EQ(*parse_error_number("-1024\n"), -1024);
  for (const char* bad : {"", "X=1\n", "1.5\n", "1 \n2\n", "99999999999\n"})
    EXPECT_FALSE(parse_error_number(bad)) << bad;
}

TEST(GcsAxisNames, AreOnePerLine) {
  EXPECT_THAT(*parse_axis_names("X \nY \nU\n"), ElementsAre("X", "Y", "U"));
  EXPECT_FALSE(parse_axis_names("\n"));
  EXPECT_FALSE(parse_axis_names("X Y\n"));
  EXPECT_FALSE(parse_axis_names("X=1\n"));
}

TEST(GcsRefusal, BecomesOneOfOurErrors) {
  EXPECT_EQ(refusal(5, "MOV X 1").reason, "NOT_REFERENCED");
  EXPECT_EQ(refusal(7, "MOV X 1").code, ErrorCode::out_of_range);
  EXPECT_EQ(refusal(10, "MOV X 1").code, ErrorCode::aborted);
  EXPECT_EQ(refusal(4711, "MOV X 1").code, ErrorCode::failed_precondition);
  EXPECT_THAT(refusal(7, "MOV X 1").message, HasSubstr("MOV X 1"));
}

TEST(StartTrap, CountsAMoveAsUnderWayUntilMotionWasSeenOrTheDelayIsOver) {
  const auto at = [](double s) { return CellTime{} + nanoseconds_from_s(s); };
  StartTrap trap(nanoseconds_from_s(0.2));
  EXPECT_FALSE(trap.under_way(false, at(0)));
  trap.commanded(at(1));
  EXPECT_TRUE(trap.under_way(false, at(1.1)));
  EXPECT_TRUE(trap.under_way(true, at(1.15)));
  EXPECT_FALSE(trap.under_way(false, at(1.16))) << "motion was seen and is over";
  trap.commanded(at(2));
  EXPECT_TRUE(trap.under_way(false, at(2.19)));
  EXPECT_FALSE(trap.under_way(false, at(2.2))) << "a move of nothing never shows motion";
}

}  // namespace
}  // namespace driftwise::gcs
