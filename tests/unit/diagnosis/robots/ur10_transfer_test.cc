// A real arm, identified on one series and predicted on another after a rigid placing only: a UR10
// under a laser tracker (tests/data/ur10_laser_tracker). The second series takes no part in
// anything but the comparison.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <random>

#include "server/diagnosis/robot/arm_diagnosis.h"
#include "server/diagnosis/robot/geometry.h"
#include "server/formats/cell_file/kinematics_section.h"
#include "server/formats/csv/dataset_csv.h"
#include "server/formats/import/import_dataset.h"
#include "server/formats/import/mapping_file.h"
#include "server/identification/pose_rows.h"
#include "server/kinematics/drawing.h"
#include "server/kinematics/rigid_fit.h"

namespace driftwise::diagnosis {
namespace {

std::string contents(const std::string& path) {
  std::ifstream file(std::string(DRIFTWISE_SOURCE_DIR) + "/" + path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

using MechanismPointer = std::shared_ptr<const kinematics::Mechanism>;

// Distance of each row from where the robot is predicted, mm, the arm placed by a rigid fit.
Eigen::VectorXd distances(const Dataset& data, const MechanismPointer& robot,
                          const Eigen::VectorXd& values) {
  const auto rows = *identification::mechanism_data(data, *robot);
  const Eigen::MatrixXd predicted = identification::predict_rows(*robot, rows.inputs, values);
  const auto placed = *kinematics::fit_rigid(predicted.transpose(), rows.outputs.transpose());
  const Eigen::MatrixXd left =
      (rows.outputs.transpose() - placed.rotation * predicted.transpose()).colwise() -
      placed.translation;
  return left.colwise().norm().transpose();
}

double rms(const Eigen::VectorXd& distance) {
  return std::sqrt(distance.squaredNorm() / static_cast<double>(distance.size()));
}

// 5 and 95 % of the share that goes, over cubes (nine rows in order) drawn with replacement.
std::pair<double, double> interval(const Eigen::VectorXd& before, const Eigen::VectorXd& after) {
  std::mt19937_64 random(1);
  const Eigen::Index cubes = before.size() / 9;
  std::vector<double> shares;
  for (int draw = 0; draw < 2000; ++draw) {
    double first = 0, second = 0;
    for (Eigen::Index i = 0; i < cubes; ++i) {
      const auto at = 9 * static_cast<Eigen::Index>(random() % static_cast<std::uint64_t>(cubes));
      first += before.segment(at, 9).squaredNorm();
      second += after.segment(at, 9).squaredNorm();
    }
    shares.push_back(1 - std::sqrt(second / first));
  }
  std::ranges::sort(shares);
  return {shares[100], shares[1899]};
}

TEST(Ur10, FindingsOfOneSeriesPredictTheOther) {
  const auto imported = [](const std::string& file, const std::string& by) {
    const auto mapping = formats::read_import_mapping(contents("deploy/mappings/" + by), by);
    EXPECT_TRUE(mapping) << mapping.error().message;
    const auto data =
        formats::import_dataset(contents("tests/data/ur10_laser_tracker/" + file), file, *mapping);
    EXPECT_TRUE(data) << data.error().message;
    return data->dataset;
  };
  const Dataset grid = imported("series_a_grid.csv.gz", "ur10_laser_tracker_a.toml");
  const Dataset cubes = imported("series_d_iso_cubes.csv.gz", "ur10_laser_tracker_d.toml");
  const MechanismPointer drawing = *kinematics::make_mechanism(
      *formats::parse_robot_file(contents("tests/data/robots/ur10.toml"), "ur10.toml"));

  identification::IdentifyOptions options;
  options.mechanism = drawing;
  const auto alone = identification::identify(grid, options);
  ASSERT_TRUE(alone) << alone.error().message;

  calibration::Candidates baseline;
  baseline.outputs = {"x", "y", "z"};
  const auto problem = lay_out(grid, baseline, grid.rows, Judging::apart);
  ASSERT_TRUE(problem) << problem.error().message;
  const auto arm = diagnose_arm(grid, *problem, drawing, {}, 0.003, {});
  ASSERT_TRUE(arm) << arm.error().message;
  const MechanismPointer bent = *kinematics::make_mechanism(arm->robot);
  const auto geometry = diagnose_geometry(grid, *problem, bent, {}, 0.003, {});
  ASSERT_TRUE(geometry) << geometry.error().message;

  const Eigen::VectorXd before = distances(cubes, drawing, alone->values()),
                        after = distances(cubes, bent, geometry->extended.values());
  const auto [low, high] = interval(before, after);
  std::vector<std::string> named;
  for (const auto& finding : arm->findings) {
    named.push_back(finding.cause + " " + finding.subject);
    std::printf("%s\n", finding.sentence.c_str());
  }
  for (const auto& one : arm->warnings) std::printf("%s\n", one.c_str());
  std::printf(
      "series D, rigid placing only: kinematics alone %.3f mm rms, with findings %.3f mm "
      "(%.1f %% less; over the cubes 90 %%: %.1f to %.1f)\n",
      rms(before), rms(after), 100 * (1 - rms(after) / rms(before)), 100 * low, 100 * high);
  EXPECT_THAT(named, testing::Contains("joint_compliance joint2"));
  EXPECT_THAT(named, testing::Not(testing::Contains(testing::HasSubstr("gear_error"))));
  EXPECT_LT(rms(after), 0.55);
  EXPECT_LT(rms(after), rms(before));
}

}  // namespace
}  // namespace driftwise::diagnosis
