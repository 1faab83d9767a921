#include "drivers/simulated/plant/micro_nano/six_bars.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "drivers/simulated/plant/numbers/random.h"

namespace driftwise::simulated {
namespace {

constexpr double kArm_mm = 70, kReach_mm = 44.8, kPlatform_mm = 25.2, kSpacing_mm = 36;
const double kDrop_mm = std::sqrt(kArm_mm * kArm_mm - kReach_mm * kReach_mm);

Vec3 outward(std::size_t arm) {
  const double angle = 2 * std::acos(-1.0) / 3 * static_cast<double>(arm);
  return {std::cos(angle), std::sin(angle), 0};
}

// A delta without faults, carriages at q.
std::array<Bar, kBars> perfect(const std::array<double, 3>& q_mm) {
  std::array<Bar, kBars> bars;
  for (std::size_t k = 0; k < kBars; ++k) {
    const Vec3 e = outward(k / 2), t = cross({0, 0, 1}, e);
    const Vec3 side = (k % 2 == 0 ? -0.5 : 0.5) * kSpacing_mm * t;
    bars[k] = {
        .carriage_mm = (kPlatform_mm + kReach_mm) * e + side + Vec3{0, 0, kDrop_mm + q_mm[k / 2]},
        .platform_mm = kPlatform_mm * e + side,
        .length_mm = kArm_mm};
  }
  return bars;
}

// Where the carriages of that robot must stand for a centre: each arm is a sphere about it.
std::array<double, 3> inverse_mm(Vec3 centre) {
  std::array<double, 3> q{};
  for (std::size_t arm = 0; arm < 3; ++arm) {
    const Vec3 e = outward(arm);
    const double radial = kReach_mm - (e.x * centre.x + e.y * centre.y);
    const double tangential = -e.y * centre.x + e.x * centre.y;
    q[arm] = centre.z + std::sqrt(kArm_mm * kArm_mm - radial * radial - tangential * tangential) -
             kDrop_mm;
  }
  return q;
}

TEST(SixBars, ForwardOfTheInverseOfAPerfectDeltaIsTheSamePoint) {
  Random random(1, "poses");
  for (int k = 0; k < 200; ++k) {
    const Vec3 wanted{random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-1, 3)};
    const PlatformPose pose = closed_pose(perfect(inverse_mm(wanted)), {});
    EXPECT_LT(norm(pose.centre_mm - wanted), 1e-10);
    EXPECT_LT(norm(rotation_vector(pose.turn)), 1e-12) << "perfect parallelograms do not tilt";
  }
}

TEST(SixBars, KeepsEveryDistanceOfAnImperfectOne) {
  Random random(2, "errors");
  for (int k = 0; k < 200; ++k) {
    auto bars = perfect({random.uniform(0, 2.5), random.uniform(0, 2.5), random.uniform(0, 2.5)});
    for (auto& bar : bars) {
      bar.length_mm += 0.05 * random.gaussian();
      bar.platform_mm = bar.platform_mm + Vec3{0.1 * random.gaussian(), 0.1 * random.gaussian(), 0};
    }
    const PlatformPose pose = closed_pose(bars, {});
    for (const auto& bar : bars) {
      const Vec3 joint = pose.centre_mm + pose.turn * bar.platform_mm;
      EXPECT_NEAR(norm(joint - bar.carriage_mm), bar.length_mm, 1e-10);
    }
    EXPECT_GT(norm(rotation_vector(pose.turn)), 1e-6);
  }
}

TEST(SixBars, TurnsAboutTheVerticalByTheDifferenceOfItsBarsOverTheirSpacing) {
  // All three pairs alike: every platform side runs ahead of the other by the same amount, as far
  // as the arms' inclination lets it: reach / arm of the difference lies in the plane.
  auto bars = perfect({1, 1, 1});
  constexpr double kDifference_mm = 0.001;
  for (std::size_t k = 1; k < kBars; k += 2) bars[k].length_mm += kDifference_mm;
  const Vec3 turn = rotation_vector(closed_pose(bars, {}).turn);
  EXPECT_NEAR(std::abs(turn.z), kDifference_mm / (kSpacing_mm * kReach_mm / kArm_mm), 1e-8);
  EXPECT_NEAR(turn.x, 0, 1e-9);
  EXPECT_NEAR(turn.y, 0, 1e-9);
}

TEST(SixBars, CarryTheWrench) {
  const auto bars = perfect({0.3, 1.1, 2.2});
  const PlatformPose pose = closed_pose(bars, {});
  const Wrench wrench{.force_n = {0.2, -0.1, 3}, .moment_nmm = {5, -7, 2}};
  const auto forces = bar_forces_n(bars, pose, wrench);
  Vec3 force = wrench.force_n, moment = wrench.moment_nmm;
  for (std::size_t k = 0; k < kBars; ++k) {
    const Vec3 lever = pose.turn * bars[k].platform_mm;
    const Vec3 towards = unit(bars[k].carriage_mm - pose.centre_mm - lever);
    force = force + forces[k] * towards;
    moment = moment + forces[k] * cross(lever, towards);
  }
  EXPECT_LT(norm(force), 1e-9);
  EXPECT_LT(norm(moment), 1e-9);
  EXPECT_LT(bar_forces_n(bars, pose, {.force_n = {0, 0, 1}, .moment_nmm = {}})[0], 0)
      << "a pull upwards presses the bars";
}

TEST(SixBars, SayWhenTheyCannotBeClosed) {
  auto bars = perfect({0, 0, 0});
  for (auto& bar : bars) bar.length_mm = 20;
  EXPECT_THROW(closed_pose(bars, {}), std::domain_error);
}

TEST(Rotation, VectorAndMatrixAgreeForSmallAndForLargeTurns) {
  for (const double size : {1e-12, 1e-7, 1e-4, 0.01, 1.0}) {
    const Vec3 v = size * unit(Vec3{0.3, -0.5, 0.8});
    const Rotation r = rotation_by(v);
    EXPECT_NEAR(norm(rotation_vector(r) - v) / size, 0, 1e-4);
    EXPECT_NEAR(norm(r * Vec3{1, 2, 3}), norm(Vec3{1, 2, 3}), 1e-12);
    EXPECT_LT(norm(inverse(r) * (r * v) - v), 1e-12);
  }
}

}  // namespace
}  // namespace driftwise::simulated
