// Value record of the manuals of the ND 281B (page 47) and the ND 287 (page 115): sign, 10
// characters of number, blank, unit, sorting, series, CR LF.

#include <gmock/gmock.h>

#include "drivers/touch_probe/nd28x_codec.h"

namespace driftwise::touch_probe {
namespace {

using testing::HasSubstr;

struct Good {
  const char* name;
  const char* reply;
  double value_mm;
};
class Nd28xRecord : public testing::TestWithParam<Good> {};
TEST_P(Nd28xRecord, IsMillimetresOfThePresentValue) {
  const auto value = parse_value(GetParam().reply);
  ASSERT_TRUE(value) << value.error().message;
  EXPECT_DOUBLE_EQ(*value, GetParam().value_mm);
}
INSTANTIATE_TEST_SUITE_P(Table, Nd28xRecord,
                         testing::Values(Good{"no_marks", "+   1.23450    \r\n", 1.2345},
                                         Good{"equal_and_present", "-      5.23  =A\r\n", -5.23},
                                         Good{"first_axis", "+   1.23450   1\r\n", 1.2345},
                                         Good{"below", "+   1.23450  < \r\n", 1.2345},
                                         Good{"above", "+   1.23450  >A\r\n", 1.2345},
                                         Good{"not_sorted", "+   1.23450  ? \r\n", 1.2345},
                                         Good{"ten_digits", "-999.999950   A\r\n", -999.99995}),
                         [](const auto& row) { return std::string(row.param.name); });

struct Refused {
  const char* name;
  const char* reply;
  const char* reason;
  const char* says;
};
class Nd28xOtherRecord : public testing::TestWithParam<Refused> {};
TEST_P(Nd28xOtherRecord, IsRefusedByItsMarks) {
  const auto value = parse_value(GetParam().reply);
  ASSERT_FALSE(value) << *value;
  EXPECT_EQ(value.error().reason, GetParam().reason);
  EXPECT_THAT(value.error().message, HasSubstr(GetParam().says));
}
INSTANTIATE_TEST_SUITE_P(
    Table, Nd28xOtherRecord,
    testing::Values(Refused{"fault", "+   1.23450 ?\r\n", "INPUT_ERROR", "faulty"},
                    Refused{"fault_in_full", "+   1.23450 ? A\r\n", "INPUT_ERROR", "faulty"},
                    Refused{"inches", "+   0.12345 \"  \r\n", "WRONG_SET_UP", "inches"},
                    Refused{"inches_sorted", "+   0.12345 \"=A\r\n", "WRONG_SET_UP", "inches"},
                    Refused{"degrees", "+   1.23450 G  \r\n", "WRONG_SET_UP", "angle"},
                    Refused{"minutes", "+  10.30.15 M  \r\n", "WRONG_SET_UP", "angle"},
                    Refused{"radians", "+   1.23450 R  \r\n", "WRONG_SET_UP", "angle"},
                    Refused{"mm_per_minute", "+   1.23450 m  \r\n", "WRONG_SET_UP", "speed"},
                    Refused{"inches_per_minute", "+   1.23450 i  \r\n", "WRONG_SET_UP", "speed"},
                    Refused{"turns", "+   1.23450 U  \r\n", "WRONG_SET_UP", "speed"},
                    Refused{"minimum", "+   1.23450   S\r\n", "WRONG_SET_UP", "MIN"},
                    Refused{"maximum", "+   1.23450  >G\r\n", "WRONG_SET_UP", "MAX"},
                    Refused{"range", "+   1.23450   D\r\n", "WRONG_SET_UP", "DIFF"},
                    Refused{"second_axis", "+   1.23450   2\r\n", "WRONG_SET_UP", "X2"},
                    Refused{"function", "+   1.23450   F\r\n", "WRONG_SET_UP", "function"},
                    Refused{"unknown_unit", "+   1.23450 x  \r\n", "BAD_REPLY", "unit"},
                    Refused{"unknown_sorting", "+   1.23450  x \r\n", "BAD_REPLY", "unit"},
                    Refused{"unknown_series", "+   1.23450   x\r\n", "BAD_REPLY", "unit"},
                    Refused{"more_columns", "+   1.23450  =AA\r\n", "BAD_REPLY", "unit"},
                    Refused{"no_number", "+            =A\r\n", "BAD_REPLY", "unit"}),
    [](const auto& row) { return std::string(row.param.name); });

// A character with a framing or parity error arrives as NUL (termios(3), INPCK).
TEST(Nd28xDamagedRecord, IsRefused) {
  EXPECT_EQ(parse_value(std::string_view("+   1.2\0"
                                         "450    \r\n",
                                         17))
                .error()
                .reason,
            "BAD_REPLY");
  EXPECT_EQ(parse_value(std::string_view("\0   1.23450    \r\n", 17)).error().reason, "BAD_REPLY");
  EXPECT_EQ(parse_value(std::string_view("+   1.23450  =\0\r\n", 17)).error().reason, "BAD_REPLY");
}

}  // namespace
}  // namespace driftwise::touch_probe
