// The judge is the way there: a pose's own target, and errors thrown at the motor coordinates.

#include "server/compensation/forward_pose.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <tuple>

#include "server/compensation/snapshot_builder.h"
#include "tests/unit/compensation/models.h"

namespace driftwise::compensation {
namespace {

using testing::HasSubstr;

constexpr CellTime kHere{1'300'000'000'000'000'000};

// Three motors of a curved, coupled robot: q1 = x + 0.02 y^2 + 3e-6 rz..., no two alike; rz in
// arcsec is stated, not solved for. Units of the model's columns: mm and rad.
Snapshot curved_robot() {
  Snapshot snapshot;
  snapshot.model = {7};
  snapshot.built_at = kHere;
  snapshot.valid_until = kHere + std::chrono::seconds(30);
  snapshot.column_per_unit.fill(1.0);
  const auto v = [](Variable variable) { return static_cast<std::uint8_t>(variable); };
  snapshot.column_per_unit[v(Variable::rz)] = M_PI / 648000;
  // 1, x, y, z, x^2, y^2, xy, rz, F
  snapshot.products = {{0, v(Variable::x)},  {0, v(Variable::y)},    {0, v(Variable::z)},
                       {1, v(Variable::x)},  {2, v(Variable::y)},    {1, v(Variable::y)},
                       {0, v(Variable::rz)}, {0, v(Variable::force)}};
  for (const Variable variable :
       {Variable::x, Variable::y, Variable::z, Variable::rz, Variable::force}) {
    snapshot.needed |= bit(variable);
    Snapshot::Input input;
    input.channel = channel_of(variable);
    input.variable = variable;
    input.min = -2;
    input.max = 2;
    snapshot.inputs.push_back(input);
  }
  const std::vector<std::vector<double>> coefficients = {
      {0.1, 1.0, 0.1, -0.2, 0.02, 0.01, 0.003, 12.0, 1e-5},
      {-0.2, -0.3, 1.1, 0.05, 0.00, 0.03, -0.01, -7.0, 2e-5},
      {0.0, 0.2, 0.0, 0.9, -0.01, 0.0, 0.02, 0.0, -1e-5}};
  for (int i = 0; i < 3; ++i) {
    Snapshot::Output output;
    output.channel = {"q" + std::to_string(i + 1), "mm"};
    output.coefficients_mm = coefficients[static_cast<std::size_t>(i)];
    output.variance_nm2 = {100.0 * (i + 1)};  // u 10, 14, 17 nm everywhere
    snapshot.outputs.push_back(output);
  }
  return snapshot;
}

TargetRequest pose_at(double x, double y, double z) {
  TargetRequest pose;
  pose.set(Variable::x, x);
  pose.set(Variable::y, y);
  pose.set(Variable::z, z);
  pose.set(Variable::rz, 1.5);
  pose.set(Variable::force, 0.5);
  return pose;
}

ForwardRequest turned_round(const Target& target) {
  ForwardRequest request;
  request.q_mm.assign(target.q_mm.begin(), target.q_mm.begin() + 3);
  request.stated.set(Variable::rz, 1.5);
  request.stated.set(Variable::force, 0.5);
  return request;
}

TEST(ForwardPose, FindsThePoseThatATargetWasAskedFor) {
  const auto robot = curved_robot();
  for (const double x : {-1.9, -0.4, 0.0, 1.7})
    for (const double y : {-1.8, 0.3, 1.9})
      for (const double z : {-1.5, 0.9}) {
        const auto there = compute_target(robot, pose_at(x, y, z));
        const auto back = forward_pose(robot, turned_round(there));
        ASSERT_TRUE(back) << back.error().message;
        ASSERT_EQ(back->coordinates.size(), 3u);
        EXPECT_NEAR(back->coordinates[0].value, x, 1e-12);
        EXPECT_NEAR(back->coordinates[1].value, y, 1e-12);
        EXPECT_NEAR(back->coordinates[2].value, z, 1e-12);
        EXPECT_EQ(back->target.flags & kOutsideDomain, 0u);
      }
}

TEST(ForwardPose, StatesTheSpreadOfThePosesThatErrorsOfTheMotorsGive) {
  const auto robot = curved_robot();
  const auto there = compute_target(robot, pose_at(1.2, -0.7, 0.4));
  const auto exact = forward_pose(robot, turned_round(there)).value();
  std::mt19937_64 random(20261122);
  std::normal_distribution<double> normal;
  constexpr int kDraws = 4000;
  std::array<double, 3> sum2{};
  for (int draw = 0; draw < kDraws; ++draw) {
    auto request = turned_round(there);
    for (std::size_t i = 0; i < 3; ++i) request.q_mm[i] += there.u_nm[i] * 1e-6 * normal(random);
    const auto moved = forward_pose(robot, request).value();
    for (std::size_t j = 0; j < 3; ++j)
      sum2[j] += std::pow(moved.coordinates[j].value - exact.coordinates[j].value, 2);
  }
  for (std::size_t j = 0; j < 3; ++j)
    EXPECT_NEAR(std::sqrt(sum2[j] / kDraws) / exact.coordinates[j].u, 1.0, 0.045)
        << "four standard deviations of the ratio with 4000 draws";
}

// Three motors side by side, as a delta near its middle: q = z + (cos a x + sin a y) / 2.
calibration::Model three_alike() {
  calibration::Model model;
  for (int i = 0; i < 3; ++i) {
    const double angle = 2 * M_PI * i / 3;
    calibration::OutputModel q;
    q.channel = {"q" + std::to_string(i + 1), "mm"};
    q.terms = {term({}), term({power("x")}), term({power("y")}), term({power("z")})};
    q.coefficients = Eigen::Vector4d(0, 0.5 * std::cos(angle), 0.5 * std::sin(angle), 1);
    q.covariance = Eigen::Matrix4d::Zero();
    q.dof = 300;
    // As a fit has them whose rows are all of one hour: the constant takes a drift up.
    for (const auto& [channel, by, slope] :
         {std::tuple("x_mm", "1", q.coefficients[1]), std::tuple("z_mm", "h", 1.0)})
      q.influences.push_back({channel, by, 1, slope * Eigen::Vector4d::Unit(0)});
    model.outputs.push_back(q);
  }
  model.domain = {{{"x", "mm"}, -4, 4}, {{"y", "mm"}, -4, 4}, {{"z", "mm"}, -4, 4}};
  return model;
}

CellDescription drifting_lasers(double x_noise_nm, double z_drift_nm, double scale_nm) {
  CellDescription cell;
  for (const char* symbol : {"x", "z"}) {
    auto& laser = cell.devices.emplace_back();
    laser.id = std::string("laser-") + symbol;
    auto& length = laser.become<LengthSettings>();
    length.channel = {symbol, "mm"};
    (*symbol == 'x' ? length.u_length_nm : length.u_drift_nm_per_h) =
        *symbol == 'x' ? x_noise_nm : z_drift_nm;
  }
  auto& motion = cell.devices.emplace_back().become<MotionSettings>();
  for (const char* symbol : {"q1", "q2", "q3"}) {
    auto& axis = motion.axes.emplace_back();
    axis.channel = {symbol, "mm"};
    axis.u_scale_nm = scale_nm;
  }
  return cell;
}

Eigen::Vector3d u_of_pose_nm(const CellDescription& cell) {
  auto builder = SnapshotBuilder::create(three_alike(), ModelId{1}, cell);
  EXPECT_TRUE(builder) << builder.error().message;
  builder->keep_model_datum();
  ForwardRequest request;
  request.q_mm = {0, 0, 0};
  const auto found = forward_pose(builder->build(kHere), request);
  EXPECT_TRUE(found) << found.error().message;
  return 1e6 *
         Eigen::Vector3d(found->coordinates[0].u, found->coordinates[1].u, found->coordinates[2].u);
}

TEST(ForwardPose, HasTheErrorOfOneLengthInThatCoordinateAlone) {
  const Eigen::Vector3d drift_nm = u_of_pose_nm(drifting_lasers(0, 10, 0));
  EXPECT_LT((drift_nm - Eigen::Vector3d(0, 0, 10)).norm(), 1e-6) << drift_nm.transpose();
  const Eigen::Vector3d both_nm = u_of_pose_nm(drifting_lasers(4, 10, 0));
  EXPECT_LT((both_nm - Eigen::Vector3d(4, 0, 10)).norm(), 1e-6) << both_nm.transpose();
}

TEST(ForwardPose, AddsTheScalesOfTheMotorsInSquares) {
  // By hand: z is their mean; x and y have 2 / 3 of q times cos and sin, twice.
  const Eigen::Vector3d nm = u_of_pose_nm(drifting_lasers(0, 10, 3));
  const double sideways_nm = 3 * std::sqrt(8.0 / 3);
  EXPECT_LT((nm - Eigen::Vector3d(sideways_nm, sideways_nm, std::hypot(10, std::sqrt(3.0)))).norm(),
            1e-6)
      << nm.transpose();
}

TEST(ForwardPose, SaysWhichCoordinatesAreToBeStated) {
  const auto robot = curved_robot();
  ForwardRequest request;
  request.q_mm = {0, 0, 0};
  auto answer = forward_pose(robot, request);
  ASSERT_FALSE(answer);
  EXPECT_EQ(answer.error().reason, "MISSING_COORDINATE") << "the force";
  request.stated.set(Variable::force, 0);
  answer = forward_pose(robot, request);
  ASSERT_FALSE(answer);
  EXPECT_EQ(answer.error().reason, "NOT_SQUARE");
  EXPECT_THAT(answer.error().message, HasSubstr("state 1 of them"));
  EXPECT_THAT(answer.error().message, HasSubstr("x_mm, y_mm, z_mm, rz_arcsec"));
}

TEST(ForwardPose, SaysSoWhereNoPoseGivesTheMotorCoordinates) {
  const auto robot = curved_robot();
  ForwardRequest request = turned_round(compute_target(robot, pose_at(0, 0, 0)));
  request.q_mm[0] = 500;
  const auto answer = forward_pose(robot, request);
  ASSERT_FALSE(answer);
  EXPECT_EQ(answer.error().reason, "NO_CONVERGENCE");
  EXPECT_THAT(answer.error().message, HasSubstr("q1_mm = 500"));
  request.q_mm[0] = std::nan("");
  EXPECT_EQ(forward_pose(robot, request).error().reason, "NOT_FINITE");
  request.q_mm.pop_back();
  EXPECT_EQ(forward_pose(robot, request).error().reason, "MISSING_VALUE");
}

TEST(ForwardPose, IsRefusedWhereNoModelServes) {
  EXPECT_EQ(forward_pose(Snapshot{}, {}).error().reason, "NO_MODEL");
}

}  // namespace
}  // namespace driftwise::compensation
