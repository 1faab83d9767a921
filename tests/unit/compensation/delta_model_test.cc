// Targets of a model with a delta's geometry, held against the closing equation of its arms.

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <string>

#include "server/compensation/forward_pose.h"
#include "tests/support/kinematics/arm_chain.h"
#include "tests/unit/compensation/geometry_models.h"

namespace driftwise::compensation {
namespace {

using Eigen::Vector3d;
using tests::kDeg;

KinematicsDescription small_delta() {
  KinematicsDescription delta;
  delta.kind = "delta-vertical";
  for (int i = 0; i < 3; ++i)
    delta.branches.push_back({.motor = {"q" + std::to_string(i + 1), "mm"},
                              .azimuth_deg = 120.0 * i + 0.1 * i,
                              .radius_mm = 40.0 + 0.05 * i,
                              .length_mm = 70.0 - 0.02 * i,
                              .offset_mm = 0.01 * i});
  return delta;
}

TEST(DeltaModel, ClosesTheArmsOfADelta) {
  const auto robot = small_delta();
  auto builder = serving(imported(robot));
  builder.keep_model_datum();
  const auto snapshot = builder.build(kBuilt);
  const Vector3d pose(1.3, -0.8, 2.1);
  TargetRequest request;
  request.set(Variable::x, pose.x());
  request.set(Variable::y, pose.y());
  request.set(Variable::z, pose.z());
  const auto target = compute_target(snapshot, request);
  ASSERT_EQ(target.refusal, Refusal::none) << refusal_error(snapshot, target).message;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& branch = robot.branches[i];
    const double a = branch.azimuth_deg * kDeg, r = branch.radius_mm, l = branch.length_mm;
    const Vector3d joint(r * std::cos(a), r * std::sin(a),
                         std::sqrt(l * l - r * r) + target.q_mm[i] - branch.offset_mm);
    EXPECT_NEAR((pose - joint).norm(), l, 1e-9);
  }
  ForwardRequest back;
  back.q_mm.assign(target.q_mm.begin(), target.q_mm.begin() + 3);
  const auto there = forward_pose(snapshot, back);
  ASSERT_TRUE(there) << there.error().message;
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_NEAR(there->coordinates[k].value, pose[static_cast<Eigen::Index>(k)], 1e-6);
}

TEST(DeltaModel, CountsADeltaFromTheZeroOfTheDatum) {
  auto builder = serving(imported(small_delta()));
  EXPECT_NE(builder.build(kBuilt).anchored, true);
  const std::vector<ChannelValue> half = {{"q1_mm", 0.5}, {"q2_mm", 0.25}};
  EXPECT_EQ(builder.anchor(half).error().reason, "INCOMPLETE_DATUM");
  const std::vector<ChannelValue> zero = {{"q1_mm", 0.5}, {"q2_mm", 0.25}, {"q3_mm", -0.125}};
  ASSERT_TRUE(builder.anchor(zero));
  const auto snapshot = builder.build(kBuilt);
  TargetRequest request;
  for (const auto variable : {Variable::x, Variable::y, Variable::z}) request.set(variable, 0);
  const auto target = compute_target(snapshot, request);
  EXPECT_EQ(target.q_mm[0], 0.5);
  EXPECT_EQ(target.q_mm[2], -0.125);
  EXPECT_EQ(target.flags & kUnanchoredDatum, 0u);
}

// The rules of a cell for targets hold for the pose that its motors give, too.
TEST(DeltaModel, RefusesThePoseOfMotorsOutsideTheDomainWhereTheCellRefuses) {
  auto model = imported(small_delta());
  for (const char* symbol : {"x", "y", "z"}) model.domain.push_back({{symbol, "mm"}, -1, 1});
  TargetRequest far_off;
  far_off.set(Variable::x, 3);
  far_off.set(Variable::y, 0);
  far_off.set(Variable::z, 0);
  for (const bool refuses : {false, true}) {
    CellDescription cell;
    cell.serving.refuse_outside_domain = refuses;
    auto builder = SnapshotBuilder::create(model, ModelId{1}, cell);
    ASSERT_TRUE(builder) << builder.error().message;
    builder->keep_model_datum();
    auto snapshot = builder->build(kBuilt);
    const auto forward = forward_pose(snapshot, [&] {
      Snapshot open = snapshot;
      open.refuse_outside_domain = false;
      const auto target = compute_target(open, far_off);
      ForwardRequest motors;
      motors.q_mm.assign(target.q_mm.begin(), target.q_mm.begin() + 3);
      return motors;
    }());
    EXPECT_EQ(forward.has_value(), !refuses);
    if (!forward) {
      EXPECT_EQ(forward.error().reason, refusal_of(snapshot, far_off).reason);
    }
  }
}

TEST(DeltaModel, RefusesAPoseThatADeltaDoesNotReach) {
  const auto snapshot = serving(imported(small_delta())).build(kBuilt);
  TargetRequest request;
  request.set(Variable::x, 200);
  request.set(Variable::y, 0);
  request.set(Variable::z, 0);
  EXPECT_EQ(refusal_of(snapshot, request).reason, "NO_POSE");
}

}  // namespace
}  // namespace driftwise::compensation
