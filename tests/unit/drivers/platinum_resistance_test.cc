#include "drivers/keithley_2701/platinum_resistance.h"

#include <gtest/gtest.h>

#include <cmath>

namespace driftwise::platinum {
namespace {

// Pt100 in ohms, IEC 60751:2008, table 1 (two decimals).
struct Row {
  double degc, ohm;
};
class Iec60751 : public testing::TestWithParam<Row> {};
TEST_P(Iec60751, AgreesToHalfADigitOfItsTable) {
  const Probe pt100{.r0_ohm = 100.0};
  EXPECT_NEAR(ohm_from_degc(GetParam().degc, pt100), GetParam().ohm, 0.005 + 1e-9);
  EXPECT_NEAR(degc_from_ohm(GetParam().ohm, pt100), GetParam().degc,
              0.005 / 0.29);  // the slope at 850 degC
}
INSTANTIATE_TEST_SUITE_P(Table, Iec60751,
                         testing::Values(Row{-190, 22.83}, Row{-150, 39.72}, Row{-100, 60.26},
                                         Row{-50, 80.31}, Row{-10, 96.09}, Row{0, 100.00},
                                         Row{10, 103.90}, Row{20, 107.79}, Row{30, 111.67},
                                         Row{50, 119.40}, Row{100, 138.51}, Row{200, 175.86},
                                         Row{400, 247.09}, Row{600, 313.71}, Row{850, 390.48}));

TEST(Pt1000, ReadsBackToNanokelvinsOverTheWholeRange) {
  const Probe probe{
      .r0_ohm = 1000.123, .a_per_degc = 3.9079e-3, .b_per_degc2 = -5.78e-7};  // a calibrated one
  for (double degc = -199.9; degc < 850; degc += 0.7)
    EXPECT_NEAR(degc_from_ohm(ohm_from_degc(degc, probe), probe), degc, 1e-9) << degc;
}

TEST(Pt1000, HasTheSlopeThatAMilliohmIsAQuarterOfAMillikelvin) {
  const Probe probe;
  EXPECT_NEAR(degc_from_ohm(ohm_from_degc(20, probe) + 1e-3, probe) - 20, 0.26e-3,
              0.005e-3);  // PROTOCOLS.md section 1
}

TEST(Pt1000, IsLinearWithoutB) {
  EXPECT_NEAR(degc_from_ohm(1080, {.r0_ohm = 1000, .a_per_degc = 4e-3, .b_per_degc2 = 0}), 20.0,
              1e-12);
}

TEST(Pt1000, GivesNoTemperatureForWhatIsNoThermometer) {
  for (const double ohm : {0.0, -5.0, 1e38, std::nan(""), 100.0, 4000.0, HUGE_VAL})
    EXPECT_TRUE(std::isnan(degc_from_ohm(ohm, {}))) << ohm;
}

}  // namespace
}  // namespace driftwise::platinum
