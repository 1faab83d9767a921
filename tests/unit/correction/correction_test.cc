#include "server/correction/correction.h"

#include <gtest/gtest.h>

#include <cmath>

namespace driftwise::correction {
namespace {

constexpr double kArcsec = 4.848136811095360e-6;  // rad, pi / 648000

// Oracle: the displacement itself, projected on the turned directions.
TEST(AlongAxes, UndoesTheProjectionOnDirectionsThatAreNotSquare) {
  const std::array<Vector3, 3> turned = {Vector3{0, 40, -25}, Vector3{-60, 0, 15},
                                         Vector3{10, 55, 0}};
  const Vector3 p = {2.5, -1.25, 0.75};
  // e_x turned by (0, ry, rz) is (1, rz, -ry), and so on round.
  const Vector3 measured = {p[0] + kArcsec * (-25 * p[1] - 40 * p[2]),
                            p[1] + kArcsec * (-60 * p[2] - 15 * p[0]),
                            p[2] + kArcsec * (55 * p[0] - 10 * p[1])};
  const Vector3 found = along_axes(measured, turned);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(found[i], p[i], 1e-12);
  EXPECT_EQ(along_axes(p, {}), p);
}

TEST(AbbeError, IsLeverTimesTiltWithTheSignsOfARightHandedRotation) {
  // By hand: a point 2.5 mm above the centre (z) moves along +x when the body turns by +ry (z
  // towards x): 2.5 mm * 50".
  const std::array<Vector3, 3> above = {Vector3{0, 0, 2.5}, Vector3{}, Vector3{}};
  EXPECT_NEAR(abbe_error(above, {.ry_arcsec = 50})[0], 2.5 * 50 * kArcsec, 1e-15);
  EXPECT_NEAR(abbe_error(above, {.ry_arcsec = 50})[0] * 1e6, 606.0,
              0.05);  // nm: the "up to 0.6 um" of the study
  // A point 2.5 mm towards y moves along -x when the body turns by +rz (x towards y).
  const std::array<Vector3, 3> beside = {Vector3{0, 2.5, 0}, Vector3{}, Vector3{}};
  EXPECT_NEAR(abbe_error(beside, {.rz_arcsec = 50})[0], -2.5 * 50 * kArcsec, 1e-15);
  EXPECT_EQ(abbe_error(beside, {.ry_arcsec = 50})[0],
            0.0);  // no lever in z: the printed pairing would say otherwise
}

// Oracle: the point itself, turned by the exact rotation matrices.
TEST(AbbeError, AgreesWithTheExactRotationOfThePointToSecondOrder) {
  const double rx = 40 * kArcsec, ry = -55 * kArcsec, rz = 30 * kArcsec;
  const Vector3 a = {3.0, -7.0, 12.0};
  const auto turn = [](Vector3 p, int axis, double angle) {
    const auto i = static_cast<std::size_t>((axis + 1) % 3),
               j = static_cast<std::size_t>((axis + 2) % 3);
    const double pi = p[i], pj = p[j];
    p[i] = pi * std::cos(angle) - pj * std::sin(angle);
    p[j] = pi * std::sin(angle) + pj * std::cos(angle);
    return p;
  };
  const Vector3 moved = turn(turn(turn(a, 0, rx), 1, ry), 2, rz);
  const Vector3 error = abbe_error({a, a, a}, {40, -55, 30});
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(error[i], moved[i] - a[i], 20.0 * (60 * kArcsec) * (60 * kArcsec));
}

// Every beam has a lever of its own. Oracle: the displacement of that beam's own point.
TEST(AbbeError, TakesForEachLengthTheLeverOfItsOwnBeam) {
  const std::array<Vector3, 3> beams = {Vector3{1, 20, 300}, Vector3{4, 50, 600},
                                        Vector3{7, 80, 900}};
  const Tilt tilt{.rx_arcsec = 10, .ry_arcsec = -20, .rz_arcsec = 30};
  const Vector3 r = {10 * kArcsec, -20 * kArcsec, 30 * kArcsec};
  const Vector3 error = abbe_error(beams, tilt);
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3& a = beams[i];
    const Vector3 cross = {r[1] * a[2] - r[2] * a[1], r[2] * a[0] - r[0] * a[2],
                           r[0] * a[1] - r[1] * a[0]};
    EXPECT_NEAR(error[i], cross[i], 1e-15) << i;
  }
}

TEST(PoseFromPaths, TakesOffEachLengthWhatItsOwnBeamSawTooMuch) {
  Stage stage;
  stage.beams[0].at_zero_mm = {0, 5, -8};
  stage.beams[1] = {.at_zero_mm = {3, 0, 11}, .per_pose = {-1, 0, 0}};
  stage.beams[2] = {.at_zero_mm = {-2, 9, 0}, .per_pose = {0, -1, 0}};
  const Tilt tilt{.rx_arcsec = 25, .ry_arcsec = 20, .rz_arcsec = -35};
  const Vector3 pose = {1.5, -0.5, 2};
  const double rx = 25 * kArcsec, ry = 20 * kArcsec, rz = -35 * kArcsec;
  // The y beam stands 3 - 1.5 mm beside, the z beam 9 + 0.5 mm: mirrors that pass fixed beams.
  const Vector3 read = {pose[0] + ry * -8 - rz * 5, pose[1] + rz * 1.5 - rx * 11,
                        pose[2] + rx * 9.5 - ry * -2};
  const Vector3 found = pose_from_paths(read, tilt, stage);
  // The lever is taken at the length as read: y reads 1.6 um beside, which times 25" is 0.19 nm.
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(found[i], pose[i], 2.5e-7) << i;
}

TEST(CosineCorrected, ShortensEveryPathByTheTiltsAcrossIt) {
  const Vector3 corrected =
      cosine_corrected({4, 4, 4}, {.rx_arcsec = 100, .ry_arcsec = 200, .rz_arcsec = 0});
  const double loss = 0.5 * (200 * kArcsec) * (200 * kArcsec);  // 1 - cos, by its series
  EXPECT_NEAR(corrected[0], 4 * (1 - loss), 1e-11);
  EXPECT_NEAR(corrected[1], 4 * (1 - loss / 4), 1e-11);
  EXPECT_NEAR(corrected[2], 4 * (1 - loss - loss / 4), 1e-11);
}

TEST(PoseFromPaths, IsTheIdentityForTheLinearAxis) {
  const Vector3 path = {1.25, 0, 0};
  EXPECT_EQ(pose_from_paths(path, {}, {}), path);
}

TEST(PoseFromPaths, MovesTheOffsetWithAMirrorThatPassesTheBeam) {
  Stage stage;
  stage.beams[0] = {.at_zero_mm = {0, 2, 0}, .per_pose = {0, -1, 0}};
  // At y = 1.5 mm half a millimetre of lever is left.
  EXPECT_NEAR(pose_from_paths({3, 1.5, 0}, {.rz_arcsec = 10}, stage)[0], 3 + 0.5 * 10 * kArcsec,
              1e-15);
}

TEST(PoseFromPaths, TakesOffWhatATiltAlonePutOn) {
  Stage stage;
  stage.cosine = true;
  stage.beams[0].at_zero_mm = {0, 5, -8};
  const Tilt tilt{.ry_arcsec = 20, .rz_arcsec = -35};
  const double read =
      20 * kArcsec * -8 - -35 * kArcsec * 5;  // at rest in zero: nothing but the tilt
  EXPECT_NEAR(pose_from_paths({read, 0, 0}, tilt, stage)[0], 0.0, 1e-10);
}

}  // namespace
}  // namespace driftwise::correction
