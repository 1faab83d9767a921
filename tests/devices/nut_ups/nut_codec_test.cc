// Bytes of upsd against the protocol's own document (RFC 9271, sections 4.2.2 and 5.3).

#include "drivers/nut_ups/nut_codec.h"

#include <gmock/gmock.h>

namespace driftwise::nut_ups {
namespace {

using testing::HasSubstr;

TEST(NutCodec, AsksForAVariableAndReadsItsValue) {
  EXPECT_EQ(get_command("rack", "ups.status"), "GET VAR rack ups.status");
  const auto value = parse_value("VAR rack ups.status \"OL CHRG\"\n", "rack", "ups.status");
  ASSERT_TRUE(value) << value.error().message;
  EXPECT_EQ(*value, "OL CHRG");
}

TEST(NutCodec, AVariableThatTheSupplyDoesNotHaveIsNoError) {
  const auto value = parse_value("ERR VAR-NOT-SUPPORTED\n", "rack", "battery.runtime");
  ASSERT_TRUE(value);
  EXPECT_FALSE(*value);
}

TEST(NutCodec, ErrorsSayWhatToDo) {
  const auto unknown = parse_value("ERR UNKNOWN-UPS\n", "rick", "ups.status");
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().reason, "UPS_NOT_THERE");
  EXPECT_THAT(unknown.error().message, HasSubstr("upsc -l"));
  for (const char* word : {"DATA-STALE", "DRIVER-NOT-CONNECTED"})
    EXPECT_EQ(parse_value("ERR " + std::string(word) + "\n", "rack", "ups.status").error().reason,
              "UPS_STALE");
  EXPECT_EQ(parse_value("ERR ACCESS-DENIED\n", "rack", "ups.status").error().reason,
            "ACCESS_DENIED");
}

TEST(NutCodec, AnAnswerToAnotherQuestionIsNone) {
  for (const char* line : {"VAR rack battery.charge \"97\"\n", "VAR rick ups.status \"OL\"\n",
                           "VAR rack ups.status OL\n", "VAR rack ups.status \"", "OK\n", ""})
    EXPECT_EQ(parse_value(line, "rack", "ups.status").error().reason, "BAD_REPLY") << line;
}

TEST(NutCodec, StatusIsAListOfWordsOfWhichSomeAreUnknown) {
  EXPECT_FALSE(parse_status("OL CHRG")->on_battery);
  EXPECT_TRUE(parse_status("OB DISCHRG")->on_battery);
  EXPECT_FALSE(parse_status("OB DISCHRG")->low_battery);
  EXPECT_TRUE(parse_status("OB LB")->low_battery);
  EXPECT_TRUE(parse_status("OB LB DISCHRG")->low_battery);
  EXPECT_TRUE(parse_status("FSD")->forced);
  EXPECT_FALSE(parse_status("OB LB")->forced);
  EXPECT_TRUE(parse_status("ALARM OL RB"));
  EXPECT_EQ(parse_status("WAIT").error().reason, "UPS_STALE");  // upsd itself has just started
  EXPECT_EQ(parse_status("CHRG").error().reason, "BAD_REPLY");
  EXPECT_EQ(parse_status("").error().reason, "BAD_REPLY");
}

// After a long power cut the battery is charged for hours, and upsd says so: nothing is about to
// go.
TEST(NutCodec, ALowBatteryBesideMainsIsNoReasonToEnd) {
  for (const char* status : {"OL CHRG LB", "OL LB", "LB CHRG OL", "OL RB LB"}) {
    ASSERT_TRUE(parse_status(status)) << status;
    EXPECT_FALSE(parse_status(status)->low_battery) << status;
    EXPECT_FALSE(parse_status(status)->on_battery) << status;
  }
}

// upsmon(8), "Forced shutdowns": it brings down a computer whose supply is otherwise well.
TEST(NutCodec, AForcedShutdownIsAboutToTakeThePowerWhateverStandsBesideIt) {
  for (const char* status :
       {"FSD", "FSD OL", "OL FSD", "OL CHRG FSD", "FSD OB", "FSD OB LB", "ALARM FSD OL"}) {
    AboutToGo about_to_go;
    EXPECT_FALSE(about_to_go.take(*parse_status("OL"))) << status;
    EXPECT_TRUE(about_to_go.take(*parse_status(status))) << status;
    EXPECT_TRUE(about_to_go.take(*parse_status(status))) << status << ", as long as it stands";
    EXPECT_TRUE(about_to_go.take(*parse_status("FSD OL"))) << "mains that return take nothing back";
    EXPECT_FALSE(about_to_go.take(*parse_status("OL"))) << "upsd was started anew";
  }
}

// A daemon that is started again beside it would end each time.
TEST(NutCodec, AForcedShutdownOfBeforeTheStartEndsNothingWhileMainsAreThere) {
  AboutToGo about_to_go;
  EXPECT_FALSE(about_to_go.take(*parse_status("FSD OL")));
  EXPECT_FALSE(about_to_go.take(*parse_status("OL FSD CHRG LB")));
  EXPECT_TRUE(about_to_go.take(*parse_status("FSD OB")));
  EXPECT_FALSE(about_to_go.take(*parse_status("FSD OL")));
  EXPECT_FALSE(about_to_go.take(*parse_status("OL")));
  EXPECT_TRUE(about_to_go.take(*parse_status("OL FSD"))) << "another one";
  EXPECT_TRUE(AboutToGo().take(*parse_status("FSD OB"))) << "without mains at the start";
  EXPECT_TRUE(AboutToGo().take(*parse_status("FSD"))) << "nothing says that mains are there";
}

TEST(NutCodec, QuantitiesAreNumbersFromZeroUp) {
  EXPECT_EQ(*parse_quantity("97", "battery.charge"), 97);
  for (const char* text : {"", "-1", "nan", "inf", "97 %", "x"})
    EXPECT_EQ(parse_quantity(text, "battery.charge").error().reason, "BAD_REPLY") << text;
}

}  // namespace
}  // namespace driftwise::nut_ups
