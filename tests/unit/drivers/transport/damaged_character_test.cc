// Answers of serial lines in which one character was damaged: it arrives as NUL (serial_stream.cc),
// and no codec may take a number of it, for these protocols have no checksum.

#include <gtest/gtest.h>

#include <functional>

#include "drivers/inclinometer/dpl_codec.h"
#include "drivers/keithley_2701/scan_codec.h"
#include "drivers/lds1000/lds_codec.h"
#include "drivers/load_actuator/load_codec.h"
#include "drivers/pi_gcs/gcs_codec.h"
#include "drivers/touch_probe/nd28x_codec.h"

namespace driftwise {
namespace {

struct Answer {
  const char* name;
  std::string text;  // without its last line end
  std::function<bool(std::string_view)> is_taken;
};
class DamagedAnswer : public testing::TestWithParam<Answer> {};

TEST_P(DamagedAnswer, IsRefusedWhicheverCharacterIsNul) {
  const auto& whole = GetParam().text;
  ASSERT_TRUE(GetParam().is_taken(whole));
  for (std::size_t at = 0; at < whole.size(); ++at) {
    auto damaged = whole;
    damaged[at] = '\0';
    EXPECT_FALSE(GetParam().is_taken(damaged)) << "character " << at;
  }
}

const std::vector<std::string> kAxes{"X", "Y"};

INSTANTIATE_TEST_SUITE_P(
    Codecs, DamagedAnswer,
    testing::Values(
        Answer{"lds1000_value", "1TP-1596.3",
               [](auto text) { return lds1000::parse_value(text, 1).has_value(); }},
        Answer{"lds1000_status", "MS@",
               [](auto text) { return lds1000::parse_status(text).has_value(); }},
        Answer{"keithley_scan", "+1.07793E+03,+101,+1.000E+01",
               [](auto text) { return keithley::parse_fields(text, 3).has_value(); }},
        Answer{"keithley_list", "(@101:110)",
               [](auto text) { return keithley::parse_channel_list(text).has_value(); }},
        Answer{"gcs_positions", "X=0.1234567 \nY=-2.5000000",
               [](auto text) { return gcs::parse_axis_values(text, kAxes).has_value(); }},
        Answer{"gcs_moving", "1", [](auto text) { return gcs::parse_hex(text).has_value(); }},
        Answer{"nd28x_value", "+   1.23450  =A",
               [](auto text) { return touch_probe::parse_value(text).has_value(); }},
        Answer{"load", "OK 2.305 0",
               [](auto text) { return load_actuator::parse_load(text).has_value(); }},
        Answer{"inclinometer", "X=+01.234\r\nY=-00.007",
               [](auto text) { return inclinometer::parse_tilt(text).has_value(); }}),
    [](const auto& row) { return std::string(row.param.name); });

}  // namespace
}  // namespace driftwise
