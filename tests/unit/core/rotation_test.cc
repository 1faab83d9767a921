#include "server/core/rotation.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <array>
#include <numbers>
#include <random>

namespace driftwise {
namespace {

using Eigen::Matrix3d, Eigen::Vector3d;
constexpr double kQuarterTurn = std::numbers::pi / 2;
constexpr std::array kAll = {RotationConvention::xyz_fixed, RotationConvention::xyz_moving,
                             RotationConvention::zyx_moving, RotationConvention::zyz_moving,
                             RotationConvention::rotation_vector};

TEST(RotationMatrix, TurnsXIntoYByAQuarterAboutZ) {
  const Vector3d y =
      rotation_matrix(RotationConvention::xyz_fixed, {0, 0, kQuarterTurn}) * Vector3d::UnitX();
  EXPECT_TRUE(y.isApprox(Vector3d::UnitY(), 1e-15)) << y.transpose();
}

// By hand: fixed axes apply the first angle first, moving axes last.
TEST(RotationMatrix, KeepsTheOrderOfItsName) {
  const Vector3d quarter_xy{kQuarterTurn, kQuarterTurn, 0};
  // z -> (about x) -y -> (about the fixed y) -y.
  EXPECT_TRUE((rotation_matrix(RotationConvention::xyz_fixed, quarter_xy) * Vector3d::UnitZ())
                  .isApprox(-Vector3d::UnitY(), 1e-15));
  // z -> (about the body's y) x -> (about x) x.
  EXPECT_TRUE((rotation_matrix(RotationConvention::xyz_moving, quarter_xy) * Vector3d::UnitZ())
                  .isApprox(Vector3d::UnitX(), 1e-15));
}

TEST(RotationAngles, GiveBackEveryRotationInEveryConvention) {
  std::mt19937 random(230);
  std::uniform_real_distribution<double> angle_rad(-3, 3);
  for (int i = 0; i < 2000; ++i) {
    const Matrix3d rotation = rotation_matrix(
        RotationConvention::rotation_vector,
        Vector3d(angle_rad(random), angle_rad(random), angle_rad(random)).normalized() *
            angle_rad(random));
    for (const auto convention : kAll) {
      const Matrix3d again = rotation_matrix(convention, rotation_angles_rad(convention, rotation));
      // The middle angle's sine or cosine divides the rounding of the matrix: 1e-16 / 1e-3.
      EXPECT_LT((again - rotation).cwiseAbs().maxCoeff(), 1e-13) << to_string(convention);
    }
  }
}

TEST(RotationAngles, StandWhereTheMiddleAngleHidesTheOthers) {
  for (const auto convention : kAll)
    for (const double middle : {-kQuarterTurn, 0.0, kQuarterTurn, 2 * kQuarterTurn})
      for (const double first : {-2.0, 0.0, 0.3}) {
        const Matrix3d rotation = rotation_matrix(convention, {first, middle, 0.7});
        const Matrix3d again =
            rotation_matrix(convention, rotation_angles_rad(convention, rotation));
        EXPECT_LT((again - rotation).cwiseAbs().maxCoeff(), 1e-7)
            << to_string(convention) << ' ' << first << ' ' << middle;
      }
}

// A product of matrices has absolute errors of 1e-16, which divided by a cosine of 1e-11 would turn
// the other two angles by seconds of arc.
TEST(RotationAngles, GiveBackAMatrixThatWasRoundedBesideTheHiddenAngles) {
  std::mt19937 random(231);
  std::uniform_real_distribution<double> angle_rad(-3, 3);
  for (const auto convention : kAll)
    for (const double beside : {1e-12, 1e-11, 1e-10, 1e-9, 1e-8, 1e-7})
      for (int i = 0; i < 100; ++i) {
        const double middle =
            (convention == RotationConvention::zyz_moving ? 0 : kQuarterTurn) + beside;
        const Matrix3d away = rotation_matrix(RotationConvention::xyz_fixed,
                                              {angle_rad(random), 1.0, angle_rad(random)});
        const Matrix3d exact =
            rotation_matrix(convention, {angle_rad(random), middle, angle_rad(random)});
        const Matrix3d rotation = away * (away.transpose() * exact);
        const Matrix3d again =
            rotation_matrix(convention, rotation_angles_rad(convention, rotation));
        EXPECT_LT((again - rotation).cwiseAbs().maxCoeff(), 1e-7)
            << to_string(convention) << ' ' << beside;
      }
}

TEST(RotationConventions, AreFoundByTheirNames) {
  for (const auto convention : kAll)
    EXPECT_EQ(*rotation_convention(to_string(convention)), convention);
  EXPECT_EQ(rotation_convention("euler").error().reason, "UNKNOWN_CONVENTION");
}

TEST(RigidTransform, UndoesItselfByItsInverse) {
  const RigidTransform there{rotation_matrix(RotationConvention::zyx_moving, {0.3, -1.1, 2.0}),
                             {120, -7, 45}};
  const RigidTransform nothing = there * there.inverse();
  EXPECT_TRUE(nothing.rotation.isApprox(Matrix3d::Identity(), 1e-14));
  EXPECT_LT(nothing.translation_mm.norm(), 1e-12);
}

TEST(NearestRotation, PutsRoundedDigitsRightAndRefusesWhatIsNone) {
  const Matrix3d exact = rotation_matrix(RotationConvention::xyz_fixed, {0.4, 0.5, 0.6});
  const Matrix3d rounded = (exact * 1e4).array().round() / 1e4;
  const auto found = nearest_rotation(rounded);
  ASSERT_TRUE(found);
  EXPECT_LT((*found * found->transpose() - Matrix3d::Identity()).norm(), 1e-14);
  EXPECT_LT((*found - exact).cwiseAbs().maxCoeff(), 1e-4);
  EXPECT_FALSE(nearest_rotation(Vector3d(1, 1, -1).asDiagonal().toDenseMatrix()));
  EXPECT_FALSE(nearest_rotation(2 * exact));
  EXPECT_FALSE(nearest_rotation(Matrix3d::Constant(NAN)));
}

}  // namespace
}  // namespace driftwise
