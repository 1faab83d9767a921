#include <gtest/gtest.h>

#include <cmath>

#include "drivers/simulated/plant/cell/beam_path.h"
#include "drivers/simulated/plant/micro_nano/flexure_hinge.h"
#include "drivers/simulated/plant/numbers/random.h"
#include "drivers/simulated/plant/numbers/units.h"

namespace driftwise::simulated {
namespace {

constexpr FlexureHinge kBlade{
    .thickness_mm = 0.07, .width_mm = 5, .length_mm = 3, .youngs_gpa = 114};

TEST(FlexureHinge, StretchesLikeABarWhenItIsStraight) {
  EXPECT_NEAR(kBlade.give_mm_n(0, 1), 3 / (114e3 * 5 * 0.07), 1e-12);                   // l / (E A)
  EXPECT_NEAR(kBlade.turning_nmm_rad(), 114e3 * 5 * std::pow(0.07, 3) / 12 / 3, 1e-9);  // E I / l
}

// The arc's elongation by integrating its bending energy over 10 000 pieces.
double arc_give_mm_n(double angle) {
  constexpr int kPieces = 10000;
  const double l = kBlade.length_mm;
  double sum = 0, square = 0;
  for (int k = 0; k < kPieces; ++k) {
    const double xi = (k + 0.5) / kPieces;
    const double offset = angle * l * (1 - xi) * (1 - xi) / 2;  // of the blade from the bar's line
    sum += offset / kPieces;
    square += offset * offset / kPieces;
  }
  return (square - sum * sum) * l / kBlade.bending_nmm2();
}

TEST(FlexureHinge, GivesMoreWhenItIsBent) {
  for (const double angle : {0.01, 0.037}) {
    EXPECT_NEAR((kBlade.give_mm_n(angle, 0) - kBlade.give_mm_n(0, 0)) / arc_give_mm_n(angle), 1,
                1e-3);
  }
}

TEST(FlexureHinge, StiffensUnderTensionTowardsTheLengthOfItsArc) {
  constexpr double kAngle = 0.03;
  EXPECT_LT(kBlade.give_mm_n(kAngle, 2), kBlade.give_mm_n(kAngle, 0));
  EXPECT_GT(kBlade.give_mm_n(kAngle, -2), kBlade.give_mm_n(kAngle, 0));
  // Pulled straight along the bar: the arc's length less its shadow, angle^2 l / 6.
  constexpr double kHuge_n = 1e6;
  const double straightened_mm =
      kHuge_n * (kBlade.give_mm_n(kAngle, kHuge_n) - kBlade.give_mm_n(0, kHuge_n));
  const double shadow_mm = kBlade.length_mm * (std::sin(kAngle) / kAngle);
  EXPECT_NEAR(straightened_mm, kBlade.length_mm - shadow_mm, 1e-6);
}

CubeFace face_at(Vec3 centre, Vec3 turn) {
  const Rotation cube = rotation_by(turn);
  return {.middle_mm = centre + cube * Vec3{-15, 0, 0},
          .normal = cube * Vec3{-1, 0, 0},
          .first = cube.ey,
          .second = cube.ez,
          .half_edge_mm = 15,
          .figure_nm = {}};
}

TEST(BeamPath, IsTheRigidBodysAbbeErrorToFirstOrder) {
  const LightRay ray{.from_mm = {-136, 2, -3}, .along = {1, 0, 0}};
  const double zero_mm = path_to(ray, face_at({}, {})).path_mm;
  Random random(3, "abbe");
  for (int k = 0; k < 50; ++k) {
    const Vec3 centre{random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(0, 2.5)};
    constexpr double kTilt = 50 * kRadPerArcsec;
    const Vec3 r{random.uniform(-kTilt, kTilt), random.uniform(-kTilt, kTilt),
                 random.uniform(-kTilt, kTilt)};
    const double moved_mm = path_to(ray, face_at(centre, r)).path_mm - zero_mm;
    const double a_y = 2 - centre.y, a_z = -3 - centre.z;  // the beam stands still
    const double first_order_mm = centre.x + r.y * a_z - r.z * a_y;
    // What is left: tilt^2 over the whole way of 121 mm and half the cube, about 15 nm at 50
    // arcsec.
    EXPECT_NEAR(moved_mm, first_order_mm, 1.2 * 121 * 2 * kTilt * kTilt);
    EXPECT_GT(std::abs(moved_mm - first_order_mm), 0);
  }
}

TEST(BeamPath, CountsHalfTheWayToTheMirrorImageOfTheHead) {
  // The returning light seems to come from the head's image in the face; the phase is what of that
  // distance lies along the beam.
  Random random(4, "image");
  for (int k = 0; k < 50; ++k) {
    const auto some = [&] { return 1e-3 * random.gaussian(); };
    const LightRay ray{.from_mm = {-136, 1, 2}, .along = unit({1, some(), some()})};
    const CubeFace face = face_at({some(), some(), some()}, {some(), some(), some()});
    const Vec3 image =
        ray.from_mm - 2 * dot(ray.from_mm - face.middle_mm, face.normal) * face.normal;
    EXPECT_NEAR(path_to(ray, face).path_mm, dot(ray.along, image - ray.from_mm) / 2, 1e-10);
  }
}

TEST(BeamPath, ThroughA45DegreeMirrorIsTheSameWayUnfolded) {
  const Vec3 fold{0, 0, 60};
  const Vec3 normal = unit({1, 0, 1});
  const LightRay level{.from_mm = {-136, 0, 60}, .along = {1, 0, 0}};
  const LightRay seen = folded(level, fold, normal);
  EXPECT_NEAR(seen.along.z, -1, 1e-12);
  EXPECT_LT(norm(seen.from_mm - Vec3{0, 0, 196}), 1e-10);
  // The mirror up by 1: the light goes on for 1 more before it is turned.
  EXPECT_NEAR(folded(level, {0, 0, 61}, normal).from_mm.z, 197, 1e-10);
  // Leaning by e, it turns the light by 2 e.
  const LightRay leaning = folded(level, fold, rotation_by({0, 1e-4, 0}) * normal);
  EXPECT_NEAR(leaning.along.x, -2e-4, 1e-7);
}

TEST(BeamPath, SeesTheFigureOfTheFace) {
  CubeFace face = face_at({}, {});
  face.figure_nm = {0, 0, 10};
  const LightRay corner{.from_mm = {-136, 15, 0}, .along = {1, 0, 0}};
  const double flat_mm = path_to(corner, face_at({}, {})).path_mm;
  EXPECT_NEAR(flat_mm - path_to(corner, face).path_mm, 10e-6, 1e-9);
}

}  // namespace
}  // namespace driftwise::simulated
