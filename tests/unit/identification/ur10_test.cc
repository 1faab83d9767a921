// A real robot, measured: tests/data/ur10_laser_tracker. Golden figures by identify.R there, which
// finds the same minimum by another method.

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>

#include "server/formats/cell_file/kinematics_section.h"
#include "server/formats/csv/dataset_csv.h"
#include "server/identification/accuracy.h"

namespace driftwise::identification {
namespace {

std::string contents(const std::string& path) {
  std::ifstream file(std::string(DRIFTWISE_SOURCE_DIR) + "/tests/data/" + path);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

Dataset measured() {
  return *formats::read_dataset_csv(contents("ur10_laser_tracker/series_a_subset.csv"), "subset");
}

MethodOptions ur10() {
  MethodOptions options;
  options.mechanism = *kinematics::make_mechanism(
      *formats::parse_robot_file(contents("robots/ur10.toml"), "ur10.toml"));
  return options;
}

TEST(Ur10, IsMillimetresFromItsDrawing) {
  const auto nominal = judge_method(measured(), Method::nominal, ur10(), {.blocks = 0});
  ASSERT_TRUE(nominal) << nominal.error().message;
  EXPECT_EQ(nominal->fitted.parameters(), 6);
  EXPECT_NEAR(nominal->position->rms, 4.0404764615, 1e-8);  // R
}

TEST(Ur10, IdentifiedFitsAsWellAsRsGaussNewton) {
  const auto found = judge_method(measured(), Method::kinematic, ur10(), {.blocks = 0});
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->fitted.parameters(), 25);              // R: rank 25
  EXPECT_NEAR(found->position->rms, 0.4316980202, 1e-9);  // R
  for (const auto& one : found->fitted.kinematics->parameters) {
    if (one.parameter.name == "link2.a_mm") {
      EXPECT_NEAR(one.value, -613.107444, 5e-6);
    }
    if (one.parameter.name == "link3.a_mm") {
      EXPECT_NEAR(one.value, -571.810289, 5e-6);
    }
  }
}

TEST(Ur10, GoalsItHasNotSeenAreNearlyAsGood) {
  const auto found = judge_method(measured(), Method::kinematic, ur10(),
                                  {.blocks = 0, .together = "line", .folds = 4});
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->groups, 207);
  ASSERT_TRUE(found->position->rms_groups) << found->warnings.front();
  EXPECT_GT(*found->position->rms_groups, found->position->rms);
  EXPECT_LT(*found->position->rms_groups, 1.25 * found->position->rms);
  // Repeated visits agree better with one another than with any rigid model of the arm.
  EXPECT_LT(*found->position->pure_error, 0.75 * *found->position->rms_groups);
}

}  // namespace
}  // namespace driftwise::identification
