#include "server/formats/csv/set_names.h"

#include <gmock/gmock.h>

#include "server/formats/csv/dataset_csv.h"
#include "server/formats/csv/trajectory_csv.h"

namespace driftwise::formats {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr const char* kNamedSetsCsv =
    "# driftwise-dataset: 1\n"
    "time_s,set,x_mm\n"
    "1,calibration,0.5\n"
    "\n"
    "2, inside ,1.5\r\n"
    "3,validation,2.5\n"
    "4,warm-2,3.5\n";

TEST(SetNames, OtherThanCalibrationAreValidationRowsOfADataset) {
  const auto data = read_dataset_csv(kNamedSetsCsv, "data.csv");
  ASSERT_TRUE(data) << data.error().message;
  EXPECT_THAT(data->set, ElementsAre(PointSet::calibration, PointSet::validation,
                                     PointSet::validation, PointSet::validation));
}

TEST(SetNames, AreReadRowByRow) {
  const auto names = read_set_names(kNamedSetsCsv, "data.csv");
  ASSERT_TRUE(names) << names.error().message;
  EXPECT_THAT(*names, ElementsAre("calibration", "inside", "validation", "warm-2"));
  EXPECT_THAT(named_sets(*names), ElementsAre("inside", "warm-2"));
}

TEST(SetNames, OfATrajectoryAreItsRowsNames) {
  const std::string text = "q1_mm,set\n0,calibration\n1,inside\n2,validation\n";
  const auto trajectory = read_trajectory_csv(text, "plan.csv");
  ASSERT_TRUE(trajectory) << trajectory.error().message;
  EXPECT_EQ(trajectory->points[1].set, PointSet::validation);
  EXPECT_THAT(*read_set_names(text, "plan.csv"),
              ElementsAre("calibration", "inside", "validation"));
}

TEST(SetNames, ThatCouldBeASlipForCalibrationAreRefused) {
  for (const char* word : {"calibratoin", "Calibration", "calib", "cal", "Kalibrierung",
                           "calibration2", "vaildation", "2inside", "in side", "inside!"}) {
    const auto data =
        read_dataset_csv(std::string("set,x_mm\ncalibration,1\n") + word + ",2\n", "data.csv");
    ASSERT_FALSE(data) << word;
    EXPECT_EQ(data.error().reason, "BAD_SET") << word;
    EXPECT_THAT(data.error().message, HasSubstr("data.csv:3")) << word;
  }
  for (const char* word : {"inside", "warm", "validation_2", "force_0.8"})
    EXPECT_EQ(is_set_name(word), std::string(word) != "force_0.8") << word;
}

TEST(SetNames, AreEmptyWithoutTheColumn) {
  EXPECT_THAT(*read_set_names("x_mm\n1\n", "data.csv"), IsEmpty());
}

TEST(SetNames, ArePutIntoATextThatIsOtherwiseUnchanged) {
  const std::string text = "# a: b\nset,x_mm\ncalibration,1\nvalidation,2\n";
  EXPECT_EQ(with_set_names(text, {"calibration", "inside"}),
            "# a: b\nset,x_mm\ncalibration,1\ninside,2\n");
  EXPECT_EQ(with_set_names(text, {"calibration"}), text);
}

TEST(SetNames, GoThroughALineOfMetadata) {
  const std::vector<std::string> names{"calibration", "calibration", "inside", "calibration"};
  EXPECT_EQ(packed_set_names(names), "calibration*2 inside*1 calibration*1");
  EXPECT_EQ(unpacked_set_names(packed_set_names(names), 4), names);
  EXPECT_THAT(unpacked_set_names("calibration*two", 2), IsEmpty());
  EXPECT_THAT(unpacked_set_names("inside*99999999999999999999", 2), IsEmpty());
}

TEST(SetNames, OfALineThatHasMoreOrFewerThanTheRowsAreNone) {
  EXPECT_THAT(unpacked_set_names("inside*2", 3), IsEmpty());
  EXPECT_THAT(unpacked_set_names("inside*2 outside*2", 3), IsEmpty());
  EXPECT_THAT(unpacked_set_names("inside*1 outside*18446744073709551615", 3), IsEmpty());
  EXPECT_EQ(unpacked_set_names("inside*100000000", 3).capacity(), 0U) << "and cost no memory";
  EXPECT_EQ(unpacked_set_names("inside*3", 3).size(), 3U);
}

}  // namespace
}  // namespace driftwise::formats
