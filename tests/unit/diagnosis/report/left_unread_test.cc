// Input of a diagnosis that it does not read: terms of constant or far channels, an arm's angles.

#include "server/diagnosis/report/left_unread.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/calibration/linear/undetermined.h"
#include "server/formats/formula/formula.h"

namespace driftwise::diagnosis {
namespace left_unread_test {
namespace {

using testing::ElementsAre;

// x over 300 mm from an offset on, with a thermometer.
std::vector<std::string> notes_of(double offset_mm, double t01_degc, double warming_k) {
  Dataset data;
  data.columns = {{{"ex", "mm"}, {}}, {{"x", "mm"}, {}}, {{"t01", "degC"}, {}}};
  for (std::size_t row = 0; row < 200; ++row) {
    ++data.rows;
    data.time_s.push_back(20.0 * static_cast<double>(row));
    data.columns[0].values.push_back(1e-5 * static_cast<double>(row * row % 17));
    data.columns[1].values.push_back(offset_mm + 20 * static_cast<double>(row % 16));
    data.columns[2].values.push_back(t01_degc + warming_k * static_cast<double>(row % 23));
  }
  const auto formula = formats::Formula::parse("ex ~ x + x^2 + t01");
  const auto problem = lay_out(data, *formula->expand(data), kMostSearched);
  if (!problem) return {problem.error().message};
  std::vector<std::string> notes;
  for (const auto& term : problem->undetermined) notes.push_back(undetermined_note(*problem, term));
  return notes;
}

TEST(LeftUnread, NothingOfATermThatTheRowsDetermine) {
  EXPECT_THAT(notes_of(0, 20, 0.01), testing::IsEmpty());
}

// 21.3 is no number of the machine: its column differs from the constant's by rounding.
TEST(LeftUnread, AConstantThermometerIsNamedWithItsValue) {
  EXPECT_THAT(notes_of(0, 21.3, 0), ElementsAre("t01 of the baseline is left out: t01 is 21.3 degC "
                                                "in every row that it learns from"));
}

TEST(LeftUnread, AnAxisFarFromZeroIsToldWhatToSubtract) {
  EXPECT_THAT(
      notes_of(1e6, 20, 0.01),
      ElementsAre("x^2 of the baseline is left out: x is 1000000 to 1000300 mm, so far from "
                  "zero that it looks the same as the terms before it; subtract 1000000 mm "
                  "from x in the file"));
}

TEST(LeftUnread, AnglesBesideTheDrawingOfAnArmAreNamed) {
  KinematicsDescription drawing;
  drawing.kind = "serial-arm";
  drawing.links = {{{"q1", "rad"}, 0, 120, 0, 90, 0},
                   {{"q2", "rad"}, 0, 0, 600, 0, 0},
                   {{"q3", "rad"}, 0, 0, 500, 0, 0}};
  const auto arm = kinematics::make_mechanism(drawing);
  ASSERT_TRUE(arm) << arm.error().message;
  Dataset data;
  for (const char* name : {"q1_rad", "x_mm", "y_mm", "z_mm", "rx_arcsec", "rz_arcsec"})
    data.columns.push_back({*parse_channel(name), {}});
  EXPECT_EQ(unread_pose_note(data, **arm),
            "not used: rx, rz; an arm is compared with its drawing in x, y, z only");
  data.columns.resize(4);
  EXPECT_EQ(unread_pose_note(data, **arm), "");
}

}  // namespace
}  // namespace left_unread_test
}  // namespace driftwise::diagnosis
