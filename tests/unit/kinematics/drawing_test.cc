#include "server/kinematics/drawing.h"

#include <gtest/gtest.h>

#include <random>

#include "server/formats/cell_file/kinematics_section.h"

namespace driftwise::kinematics {
namespace {

KinematicsDescription delta_drawing() {
  KinematicsDescription drawing;
  drawing.kind = "delta-vertical";
  for (int i = 0; i < 3; ++i)
    drawing.branches.push_back(
        {{"q" + std::to_string(i + 1), "mm"}, 120.0 * i, 30, 60, 0, 0, 0, 0});
  return drawing;
}

KinematicsDescription arm_drawing() {
  KinematicsDescription drawing;
  drawing.kind = "serial-arm";
  drawing.links = {{{"q1", "rad"}, 0, 120, 0, 90, 0},
                   {{"q2", "rad"}, 0, 0, 600, 0, 0},
                   {{"q3", "rad"}, 0, 0, 500, 0, 0}};
  return drawing;
}

KinematicsDescription axis_drawing() {
  KinematicsDescription drawing;
  drawing.kind = "linear-axis";
  drawing.axes = {{{"q1", "mm"}, {"x", "mm"}, 0, 0}};
  return drawing;
}

TEST(Drawing, WithValuesReadBackFromItsFileHasTheseValues) {
  std::mt19937_64 random(7);
  for (const auto& drawing : {delta_drawing(), arm_drawing(), axis_drawing()}) {
    const auto mechanism = make_mechanism(drawing);
    ASSERT_TRUE(mechanism) << mechanism.error().message;
    Eigen::VectorXd values = nominal_values((*mechanism)->parameters());
    for (double& value : values) value += std::uniform_real_distribution<double>(-0.1, 0.1)(random);
    const auto text = formats::write_robot_file(with_values(**mechanism, values));
    const auto again = formats::parse_robot_file(text, "written.toml");
    ASSERT_TRUE(again) << again.error().message << "\n" << text;
    const auto remade = make_mechanism(*again);
    ASSERT_TRUE(remade) << remade.error().message;
    ASSERT_EQ((*remade)->parameters().size(), (*mechanism)->parameters().size()) << drawing.kind;
    for (std::size_t k = 0; k < (*remade)->parameters().size(); ++k)
      EXPECT_EQ((*remade)->parameters()[k].nominal, values[static_cast<Eigen::Index>(k)])
          << (*remade)->parameters()[k].name;
  }
}

}  // namespace
}  // namespace driftwise::kinematics
