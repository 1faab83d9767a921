// Targets of a model with an arm's geometry, held against homogeneous matrices multiplied here.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <numbers>

#include "server/compensation/forward_pose.h"
#include "server/compensation/snapshot_builder.h"
#include "server/compensation/target.h"
#include "server/effects/term_order.h"
#include "server/formats/cell_file/kinematics_section.h"
#include "tests/support/kinematics/arm_chain.h"
#include "tests/unit/compensation/geometry_models.h"

namespace driftwise::compensation {
namespace {

using Eigen::Matrix4d;
using Eigen::Vector3d;
using tests::forward;
using tests::kArcsec;
using tests::kDeg;
using tests::rotations_arcsec;

constexpr double kWarm_degC = 24;

KinematicsDescription ur10() {
  std::ifstream file(std::string(DRIFTWISE_SOURCE_DIR) + "/tests/data/robots/ur10.toml");
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  return *formats::parse_robot_file(text, "ur10.toml");
}

KinematicsDescription bent_ur10() {
  auto arm = ur10();
  arm.links[1].errors.sag_urad_per_m = 1250;
  arm.links[2].errors.sag_urad_per_m = 740;
  arm.links[2].errors.gear_cos1_arcsec = 30;
  arm.links[2].errors.gear_sin2_arcsec = 12;
  arm.links[3].errors.drift_channel = {"air", "degC"};
  arm.links[3].errors.drift_arcsec_per_k = 4;
  return arm;
}

TargetRequest pose_of(const Matrix4d& m) {
  TargetRequest request;
  request.with_uncertainty = false;
  request.set(Variable::x, m(0, 3));
  request.set(Variable::y, m(1, 3));
  request.set(Variable::z, m(2, 3));
  const auto [rx, ry, rz] = rotations_arcsec(m);
  request.set(Variable::rx, rx);
  request.set(Variable::ry, ry);
  request.set(Variable::rz, rz);
  return request;
}

TargetRequest near(TargetRequest request, const std::vector<double>& q_rad) {
  for (std::size_t j = 0; j < q_rad.size(); ++j)
    EXPECT_EQ(set_near(request, "q" + std::to_string(j + 1) + "_rad", q_rad[j]), NearName::taken);
  return request;
}

Snapshot warm_snapshot(const calibration::Model& model) {
  auto builder = serving(model);
  const ChannelValue air{"air_degC", kWarm_degC};
  builder.observe({&air, 1}, kBuilt);
  return builder.build(kBuilt);
}

const std::vector<double> kPosture = {0.3, -1.2, 1.4, -1.0, 1.1, 0.5};

TEST(GeometryModel, BringsAnArmsToolToThePoseToANanometre) {
  const auto robot = bent_ur10();
  const auto snapshot = warm_snapshot(imported(robot));
  for (const double by : {0.0, 0.35, -0.4}) {
    auto q = kPosture;
    for (double& angle : q) angle += by;
    const Matrix4d wanted = forward(robot, q, kWarm_degC);
    auto off = q;
    off[1] += 0.2;
    const auto target = compute_target(snapshot, near(pose_of(wanted), off));
    ASSERT_EQ(target.refusal, Refusal::none) << refusal_error(snapshot, target).message;
    const std::vector<double> found(target.q_mm.begin(), target.q_mm.begin() + 6);
    const Matrix4d reached = forward(robot, found, kWarm_degC);
    EXPECT_LT((reached - wanted).block(0, 3, 3, 1).norm() * 1e6, 1);
    EXPECT_LT((reached - wanted).topLeftCorner(3, 3).norm(), 1e-9);
    for (std::size_t j = 0; j < 6; ++j) EXPECT_NEAR(found[j], q[j], 1e-7);
  }
}

TEST(GeometryModel, FollowsTheTemperatureThatAJointDriftsWith) {
  const auto robot = bent_ur10();
  auto builder = serving(imported(robot));
  const auto request = near(pose_of(forward(robot, kPosture, kWarm_degC)), kPosture);
  double angle[2];
  for (const int later : {0, 1}) {
    const ChannelValue air{"air_degC", kWarm_degC + later};
    builder.observe({&air, 1}, kBuilt);
    angle[later] = compute_target(builder.build(kBuilt), request).q_mm[3];
  }
  EXPECT_NEAR((angle[1] - angle[0]) / kArcsec, -4, 1e-3);  // 4 arcsec/K are taken back
}

TEST(GeometryModel, SaysThatAnImportedGeometryWasNotJudged) {
  const auto snapshot = warm_snapshot(imported(bent_ur10()));
  auto request = near(pose_of(forward(bent_ur10(), kPosture, kWarm_degC)), kPosture);
  request.with_uncertainty = true;
  const auto target = compute_target(snapshot, request);
  ASSERT_EQ(target.refusal, Refusal::none);
  EXPECT_TRUE(std::isnan(target.u_nm[0]));
  EXPECT_NE(describe_flags(snapshot, target).find("UNJUDGED_MODEL"), std::string::npos);
}

// A target of an arm is its geometry's inverse: what a term adds would be left out of it.
TEST(GeometryModel, OfAnArmIsRefusedWithTermsBesideIt) {
  auto model = imported(bent_ur10());
  auto& x = model.outputs.emplace_back();
  x.channel = {"x", "mm"};
  x.terms = {{{effects::Power{"air", 1}}}};
  x.coefficients = Eigen::VectorXd::Constant(1, 0.02);
  model.domain.push_back({{"air", "degC"}, 20, 25});
  const auto refused = SnapshotBuilder::create(model, ModelId{1}, CellDescription{});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "TERM_NOT_SERVABLE");
  EXPECT_NE(refused.error().message.find("air"), std::string::npos) << refused.error().message;
}

// A model stored before, whose geometry stands in the mean of two datums: 0.5 mm off in both.
TEST(GeometryModel, OfAnArmIsRefusedWithAConstantBesideItUnlessItIsZero) {
  auto model = imported(bent_ur10());
  auto& x = model.outputs.emplace_back();
  x.channel = {"x", "mm"};
  x.terms = {effects::Term{}, effects::datum_term(2)};
  x.coefficients = Eigen::Vector2d(-0.49711, 0.99422);
  const auto refused = SnapshotBuilder::create(model, ModelId{1}, CellDescription{});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "TERM_NOT_SERVABLE");
  EXPECT_NE(refused.error().message.find("a constant of -0.49711 mm of x"), std::string::npos)
      << refused.error().message;
  x.coefficients[0] = 0;  // datum(2) alone: the geometry is that of the first
  EXPECT_TRUE(SnapshotBuilder::create(model, ModelId{1}, CellDescription{}));
}

TEST(GeometryModel, IsNearestToWhereTheArmStandsUnlessTheRequestSays) {
  const auto robot = bent_ur10();
  auto builder = serving(imported(robot));
  const auto request = pose_of(forward(robot, kPosture, 20));
  const auto unknown = refusal_of(builder.build(kBuilt), request);
  EXPECT_EQ(unknown.reason, "MISSING_VALUE");
  EXPECT_NE(unknown.message.find("q1_rad"), std::string::npos);
  // The wrist turned over.
  const std::vector<double> over = {
      0.3, -1.2, 1.4, -1.0 + std::numbers::pi, -1.1, 0.5 - std::numbers::pi};
  std::vector<ChannelValue> standing;
  for (std::size_t j = 0; j < 6; ++j)
    standing.push_back({"q" + std::to_string(j + 1) + "_rad", over[j]});
  builder.observe(standing, kBuilt);
  const auto snapshot = builder.build(kBuilt);
  EXPECT_LT(compute_target(snapshot, request).q_mm[4], 0);
  EXPECT_GT(compute_target(snapshot, near(request, kPosture)).q_mm[4], 0);
}

TEST(GeometryModel, RefusesPosesByName) {
  const auto robot = bent_ur10();
  const auto snapshot = warm_snapshot(imported(robot));
  const auto refused = [&](const std::vector<double>& q) {
    return refusal_of(snapshot, near(pose_of(forward(robot, q, kWarm_degC)), q)).reason;
  };
  EXPECT_EQ(refused({0.3, -1.2, 1.4, -1.0, 0.001, 0.5}), "NO_POSE(wrist)");
  EXPECT_EQ(refused({0.3, -1.2, 0.001, -1.0, 1.1, 0.5}), "NO_POSE(elbow)");
  auto far = near(pose_of(forward(robot, kPosture, kWarm_degC)), kPosture);
  far.set(Variable::x, 9000);
  const auto error = refusal_of(snapshot, far);
  EXPECT_EQ(error.reason, "NO_POSE");
  EXPECT_EQ(error.code, ErrorCode::out_of_range);
}

TEST(GeometryModel, ChoosesAmongSolutionsWithinTheLimitsOfTheJoints) {
  auto robot = bent_ur10();
  robot.links[4].min_deg = -180;
  robot.links[4].max_deg = 0;
  auto snapshot = warm_snapshot(imported(robot));
  const auto request = near(pose_of(forward(robot, kPosture, kWarm_degC)), kPosture);
  const auto target = compute_target(snapshot, request);
  ASSERT_EQ(target.refusal, Refusal::none) << refusal_error(snapshot, target).message;
  EXPECT_LT(target.q_mm[4], 0);  // 1.1 rad would be nearer
  robot.links[4].min_deg = 10;
  robot.links[4].max_deg = 20;  // of all solutions about +-63 degrees and others: none is there
  snapshot = warm_snapshot(imported(robot));
  const auto error = refusal_of(snapshot, request);
  EXPECT_EQ(error.reason, "OUTSIDE_LIMITS(q5)");
  EXPECT_NE(error.message.find("q5_rad"), std::string::npos) << error.message;
}

TEST(GeometryModel, TakesTheTurnThatTheLimitsAllow) {
  auto robot = bent_ur10();
  robot.links[4].min_deg = 0;  // the wrist stays as it is
  robot.links[5].min_deg = 180;
  robot.links[5].max_deg = 540;
  const auto snapshot = warm_snapshot(imported(robot));
  auto close = kPosture;
  close[5] += 2.9;  // still nearer to the turn that is beyond the limits
  const auto request = near(pose_of(forward(robot, kPosture, kWarm_degC)), close);
  const auto target = compute_target(snapshot, request);
  ASSERT_EQ(target.refusal, Refusal::none);
  EXPECT_NEAR(target.q_mm[5], kPosture[5] + 2 * std::numbers::pi, 1e-7);
}

// Three joints, so that a solution is cheap.
KinematicsDescription lifting_arm() {
  KinematicsDescription arm;
  arm.kind = "serial-arm";
  arm.links = {{{"q1", "deg"}, 0, 300, 0, 90, 0},
               {{"q2", "deg"}, 0, 0, 500, 0, 0},
               {{"q3", "deg"}, 0, 0, 400, 0, 0}};
  return arm;
}

calibration::Model identified_arm(const KinematicsDescription& robot) {
  auto model = imported(robot);
  model.geometry->parameters = {{"link2.a_mm", 500, 0.02, true, ""},
                                {"link1.d_mm", 300, 0, false, "held"},
                                {"link3.a_mm", 400, 0.03, true, ""},
                                {"link2.theta_deg", 0, 0.004, true, ""}};
  model.geometry->covariance = Eigen::Vector3d(4e-4, 9e-4, 1.6e-5).asDiagonal();
  for (const char* axis : {"x", "y", "z"}) {
    calibration::OutputModel output;
    output.channel = {axis, "mm"};
    output.accuracy.a90_calibration = 1;
    output.accuracy.a90_blocks = 0.05 * kSigmaToU90;
    model.outputs.push_back(output);
  }
  model.domain = {{{"x", "mm"}, 200, 700},
                  {{"y", "mm"}, 0, 400},
                  {{"z", "mm"}, 100, 600},
                  {{"q2", "deg"}, -20, 45}};
  return model;
}

TEST(GeometryModel, StatesTheParametersUncertaintyThroughTheInverseJacobian) {
  const auto robot = lifting_arm();
  const auto request_of = [](const Vector3d& point) {
    TargetRequest request;
    request.set(Variable::x, point.x());
    request.set(Variable::y, point.y());
    request.set(Variable::z, point.z());
    set_near(request, "q1_deg", 20), set_near(request, "q2_deg", 40);
    set_near(request, "q3_deg", -70);
    return request;
  };
  const Vector3d point = forward(robot, {20 * kDeg, 40 * kDeg, -70 * kDeg}, 20).block<3, 1>(0, 3);
  const auto solved = [&](const KinematicsDescription& arm, const Vector3d& at) {
    const auto target = compute_target(serving(imported(arm)).build(kBuilt), request_of(at));
    return Vector3d(target.q_mm[0], target.q_mm[1], target.q_mm[2]);
  };
  // Each parameter moved by its standard error, each coordinate by what is left of it.
  const Vector3d plain = solved(robot, point);
  Vector3d fit = Vector3d::Zero(), residual = Vector3d::Zero();
  for (const int which : {0, 1, 2}) {
    auto moved = robot;
    if (which == 0) moved.links[1].a_mm += 0.02;
    if (which == 1) moved.links[2].a_mm += 0.03;
    if (which == 2) moved.links[1].theta_deg += 0.004;
    fit += (solved(moved, point) - plain).cwiseAbs2();
    residual += (solved(robot, point + 0.05 * Vector3d::Unit(which)) - plain).cwiseAbs2();
  }
  const auto snapshot = serving(identified_arm(robot)).build(kBuilt);
  const auto target = compute_target(snapshot, request_of(point));
  ASSERT_EQ(target.refusal, Refusal::none);
  EXPECT_EQ(target.flags & (kUnjudgedModel | kOutsideDomain | kUnanchoredDatum), 0u);
  for (std::size_t j = 0; j < 3; ++j) {
    const auto i = static_cast<Eigen::Index>(j);
    EXPECT_NEAR(target.u_nm[j] * 1e-6, std::sqrt(fit[i] + residual[i]),
                2e-3 * target.u_nm[j] * 1e-6);
    const auto budget = compute_budget(snapshot, request_of(point), j);
    EXPECT_NEAR(budget.u_nm, target.u_nm[j], 1e-6 * target.u_nm[j]);
    // The answer that was found is not looked for again: whatever it is to be near to.
    auto elsewhere = request_of(point);
    elsewhere.near_rad.fill(1);
    EXPECT_EQ(compute_budget(snapshot, elsewhere, j, {target.q_mm.data(), 3}).u_nm, budget.u_nm);
  }
  // A joint beyond the angles that it was calibrated at is outside, as a pose is.
  const Vector3d steep = forward(robot, {20 * kDeg, 60 * kDeg, -70 * kDeg}, 20).block<3, 1>(0, 3);
  EXPECT_NE(describe_flags(snapshot, compute_target(snapshot, request_of(steep))).find("q2_deg"),
            std::string::npos);
}

// The other elbow: the pose is well inside, q2 a half width and more beyond its angles.
TEST(GeometryModel, CountsAJointOutsideItsAnglesInTheUncertaintyAndInTheCellsRule) {
  const auto robot = lifting_arm();
  auto model = identified_arm(robot);
  model.domain[2].max = 900;
  auto calibrated = model;
  calibrated.domain[3].max = 90;
  const Vector3d point = forward(robot, {20 * kDeg, 80 * kDeg, -70 * kDeg}, 20).block<3, 1>(0, 3);
  TargetRequest request;
  request.set(Variable::x, point.x());
  request.set(Variable::y, point.y());
  request.set(Variable::z, point.z());
  set_near(request, "q1_deg", 20), set_near(request, "q2_deg", 80),
      set_near(request, "q3_deg", -70);
  const auto snapshot = serving(model).build(kBuilt);
  const auto inside = serving(calibrated).build(kBuilt);
  const auto target = compute_target(snapshot, request);
  ASSERT_EQ(target.refusal, Refusal::none) << refusal_error(snapshot, target).message;
  EXPECT_NE(describe_flags(snapshot, target).find("OUTSIDE_DOMAIN(q2_deg)"), std::string::npos);
  // -20 .. 45 and half a percent on each side; (1 + d)^2, d in half widths.
  const double half_width = 0.505 * 65,
               factor = std::pow(1 + (80 - 12.5 - half_width) / half_width, 2);
  EXPECT_GT(factor, 4);
  const auto within = compute_target(inside, request);
  EXPECT_EQ(within.flags & kOutsideDomain, 0u);
  for (std::size_t j = 0; j < 3; ++j) {
    EXPECT_NEAR(target.u_nm[j], factor * within.u_nm[j], 1e-6 * target.u_nm[j]);
    const auto budget = compute_budget(snapshot, request, j);
    EXPECT_NEAR(budget.u_nm, target.u_nm[j], 1e-6 * target.u_nm[j]);
    EXPECT_EQ(budget.line[budget.lines - 1].source, UncertaintySource::extrapolation);
  }
  EXPECT_NEAR(error_parts(snapshot, request).factor, factor, 1e-6 * factor);
  ForwardRequest joints;
  joints.q_mm = {20, 80, -70};
  const auto there = forward_pose(snapshot, joints), near_by = forward_pose(inside, joints);
  ASSERT_TRUE(there) << there.error().message;
  EXPECT_NEAR(there->coordinates[0].u, factor * near_by->coordinates[0].u,
              1e-6 * there->coordinates[0].u);

  CellDescription strict;
  strict.serving.refuse_outside_domain = true;
  const auto refusing = SnapshotBuilder::create(model, ModelId{1}, strict)->build(kBuilt);
  const auto refused = refusal_of(refusing, request);
  EXPECT_EQ(refused.reason, "OUTSIDE_DOMAIN");
  EXPECT_NE(refused.message.find("q2_deg"), std::string::npos) << refused.message;
  EXPECT_FALSE(forward_pose(refusing, joints));
}

TEST(GeometryModel, SaysWhereAnArmsToolIs) {
  const auto robot = bent_ur10();
  const auto snapshot = warm_snapshot(imported(robot));
  ForwardRequest request;
  request.q_mm = kPosture;
  const auto pose = forward_pose(snapshot, request);
  ASSERT_TRUE(pose) << pose.error().message;
  const Matrix4d wanted = forward(robot, kPosture, kWarm_degC);
  ASSERT_EQ(pose->coordinates.size(), 6u);
  for (int k : {0, 1, 2})
    EXPECT_NEAR(pose->coordinates[static_cast<std::size_t>(k)].value, wanted(k, 3), 1e-6);
  EXPECT_NEAR(pose->coordinates[5].value, rotations_arcsec(wanted)[2], 1e-3);
}

// The forward law is defined where the inverse is not: a wrist whose axes are parallel, an arm
// stretched out.
TEST(GeometryModel, SaysWhereAnArmsToolIsInASingularPose) {
  const auto robot = bent_ur10();
  const auto snapshot = warm_snapshot(imported(robot));
  for (const std::vector<double>& q : {std::vector<double>{0.3, -1.2, 1.4, -1.0, 0, 0.5},
                                       std::vector<double>{0, -std::numbers::pi / 2, 0, 0, 0, 0}}) {
    ForwardRequest request;
    request.q_mm = q;
    const auto pose = forward_pose(snapshot, request);
    ASSERT_TRUE(pose) << pose.error().message;
    const Matrix4d wanted = forward(robot, q, kWarm_degC);
    for (int k : {0, 1, 2})
      EXPECT_NEAR(pose->coordinates[static_cast<std::size_t>(k)].value, wanted(k, 3), 1e-6);
  }
}

// A tool axis that stands upright: ry is +-90 degrees, and only rz minus or plus rx shows.
TEST(GeometryModel, SaysHowAnArmsToolIsTurnedWhereRyIsAQuarterTurn) {
  const auto robot = ur10();
  const auto snapshot = warm_snapshot(imported(robot));
  for (const double sixth : {-std::numbers::pi / 2, std::numbers::pi / 2})
    for (const double first : {-2.1, 0.3, 0.7, 1.9}) {
      ForwardRequest request;
      request.q_mm = {first, -1.2, 1.4, -0.2, std::numbers::pi / 2, sixth};
      const auto pose = forward_pose(snapshot, request);
      ASSERT_TRUE(pose) << pose.error().message;
      const auto angle = [&](std::size_t k) { return pose->coordinates[k].value * kArcsec; };
      EXPECT_NEAR(std::abs(angle(4)), std::numbers::pi / 2, 1e-8);
      EXPECT_EQ(angle(5), 0);
      const Matrix4d again =
          tests::turn(2, angle(5)) * tests::turn(1, angle(4)) * tests::turn(0, angle(3));
      const Matrix4d wanted = forward(robot, request.q_mm, kWarm_degC);
      EXPECT_LT((again - wanted).topLeftCorner(3, 3).cwiseAbs().maxCoeff(), 1e-7) << first;
    }
}

// u of x, y, z of an arm that is stretched out by 1 m along x, mm. Arcsec per kelvin that each
// joint drifts by with the air, which was read or never.
Vector3d u_stretched_out(const std::array<double, 3>& drifts_arcsec_per_k, bool air_is_read) {
  auto robot = lifting_arm();
  robot.links[1].a_mm = 600;
  for (std::size_t j = 0; j < 3; ++j) {
    if (drifts_arcsec_per_k[j] == 0) continue;
    robot.links[j].errors.drift_channel = {"air", "degC"};
    robot.links[j].errors.drift_arcsec_per_k = drifts_arcsec_per_k[j];
  }
  auto model = identified_arm(robot);
  model.domain[0].max = 1200;
  model.domain.push_back({{"air", "degC"}, 18, 24});
  auto builder = serving(model);
  const ChannelValue air{"air_degC", 21};  // the middle, which stands in for a missing one
  if (air_is_read) builder.observe({&air, 1}, kBuilt);
  ForwardRequest request;
  request.q_mm = {0, 0, 0};
  const auto pose = forward_pose(builder.build(kBuilt), request);
  EXPECT_TRUE(pose) << pose.error().message;
  return {pose->coordinates[0].u, pose->coordinates[1].u, pose->coordinates[2].u};
}

// Of a rectangle over the fitted range and half a percent on each side.
const double kMissingAir_k = 1.01 * 6 / std::sqrt(12.0);

TEST(GeometryModel, CountsAMissingThermometerOfAJointInTheUncertaintyOfAPose) {
  const Vector3d read = u_stretched_out({14, 0, 0}, true);
  const Vector3d missing = u_stretched_out({14, 0, 0}, false);
  const double lever_times_turn_mm = 1000 * 14 * kArcsec * kMissingAir_k;
  EXPECT_GT(lever_times_turn_mm, 2 * read.y()) << "else it would hardly show";
  EXPECT_NEAR(missing.y(), std::hypot(read.y(), lever_times_turn_mm), 1e-6);
  EXPECT_NEAR(missing.x(), read.x(), 1e-6);
  EXPECT_NEAR(missing.z(), read.z(), 1e-6);
}

// The second joint lifts 1 m and the third 0.4 m, about parallel axes.
TEST(GeometryModel, AddsTheTurnsOfAMissingThermometersJointsWithTheirSigns) {
  for (const double third : {-35.0, 35.0}) {
    const Vector3d read = u_stretched_out({0, 14, third}, true);
    const Vector3d missing = u_stretched_out({0, 14, third}, false);
    const double lifted_mm = (1000 * 14 + 400 * third) * kArcsec * kMissingAir_k;
    EXPECT_NEAR(missing.z(), std::hypot(read.z(), lifted_mm), 1e-6) << third;
    EXPECT_NEAR(missing.y(), read.y(), 1e-6) << third;
  }
}

// Another solution of the same pose, within the limits, has nothing to say.
TEST(GeometryModel, FlagsTheJointsAsStatedWhereTheyStandBeyondTheirLimits) {
  auto robot = bent_ur10();
  robot.links[4].min_deg = 0;  // the wrist turned over is allowed ...
  const auto snapshot = warm_snapshot(imported(robot));
  ForwardRequest request;
  request.q_mm = kPosture;
  request.q_mm[4] = -1.1;  // ... and this side is not
  const auto pose = forward_pose(snapshot, request);
  ASSERT_TRUE(pose) << pose.error().message;
  EXPECT_NE(pose->target.flags & kOutsideLimits, 0u);
  EXPECT_EQ(pose->target.unreachable, 1u << 4);
  for (std::size_t j = 0; j < 6; ++j) EXPECT_EQ(pose->target.q_mm[j], request.q_mm[j]);
}

TEST(GeometryModel, SaysWhichRequestsOfAnArmTakeASearch) {
  const auto robot = bent_ur10();
  const auto snapshot = warm_snapshot(imported(robot));
  const auto pose = pose_of(forward(robot, kPosture, kWarm_degC));
  auto far_off = kPosture;
  for (double& angle : far_off) angle += 2;
  EXPECT_FALSE(needs_search(snapshot, near(pose, kPosture)));
  EXPECT_TRUE(needs_search(snapshot, near(pose, far_off)));
  auto unreachable = pose;
  unreachable.set(Variable::x, 9000);
  EXPECT_FALSE(needs_search(snapshot, near(unreachable, far_off)));
  EXPECT_EQ(refusal_of(snapshot, near(unreachable, far_off)).reason, "NO_POSE");
  EXPECT_FALSE(needs_search(snapshot, pose));  // refused: where the joints stand was not read
}

}  // namespace
}  // namespace driftwise::compensation
