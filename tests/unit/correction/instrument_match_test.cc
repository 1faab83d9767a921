// Against parameters that were put in, against Monte Carlo for the uncertainties, and against an
// iterated least squares that shares nothing with the closed form.
#include "server/correction/instrument_match.h"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <random>

namespace driftwise::correction {
namespace {

using testing::HasSubstr;

const double kRadOfArcsec = std::acos(-1.0) / 648000;

struct Truth {
  double scale_ppm = 80;
  Eigen::Vector3d offset_mm{0.2, -0.1, 0.05};
  Eigen::Vector3d turn_arcsec{200, -350, 500};
  double noise_nm = 20;
};

Eigen::Matrix3d rotation_of(const Eigen::Vector3d& turn_arcsec) {
  const double angle = turn_arcsec.norm() * kRadOfArcsec;
  return Eigen::AngleAxisd(angle, turn_arcsec.normalized()).toRotationMatrix();
}

struct Tables {
  InstrumentRows reference{"run 3", {}, {}, {}}, other{"cmm.csv", {}, {}, {}};
};

Tables tables_of(const Truth& truth, std::uint64_t seed, int rows = 125) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0, truth.noise_nm * 1e-6);
  Tables out;
  out.reference.mm.resize(3, rows);
  out.other.mm.resize(3, rows);
  const auto rotation = rotation_of(truth.turn_arcsec);
  for (int k = 0; k < rows; ++k) {
    out.reference.row.push_back(k + 1);
    out.other.row.push_back(k + 1);
    const Eigen::Vector3d p(k % 5 * 0.5, k / 5 % 5 * 0.5, k / 25 * 0.5);
    out.reference.mm.col(k) = p;
    out.other.mm.col(k) = truth.offset_mm + (1 + truth.scale_ppm * 1e-6) * rotation * p +
                          Eigen::Vector3d(normal(random), normal(random), normal(random));
  }
  return out;
}

const std::vector<std::string> kXyz{"x", "y", "z"};

TEST(InstrumentMatch, FindsScaleOffsetAndRotationThatWerePutIn) {
  const auto tables = tables_of({.noise_nm = 0}, 1);
  const auto match = match_instruments(tables.reference, tables.other, kXyz);
  ASSERT_TRUE(match) << match.error().message;
  EXPECT_NEAR(match->scale_ppm, 80, 1e-6);
  EXPECT_NEAR(match->offset_nm[0], 0.2e6, 1e-3);
  EXPECT_NEAR(match->offset_nm[2], 0.05e6, 1e-3);
  EXPECT_NEAR(match->rotation_arcsec[0], 200, 1e-6);
  EXPECT_NEAR(match->rotation_arcsec[1], -350, 1e-6);
  EXPECT_NEAR(match->rotation_arcsec[2], 500, 1e-6);
  EXPECT_LT(match->residual_nm.cwiseAbs().maxCoeff(), 1e-3);
}

TEST(InstrumentMatch, AgreesWithIteratedLeastSquares) {
  const auto tables = tables_of({}, 2);
  const auto match = *match_instruments(tables.reference, tables.other, kXyz);
  // Gauss-Newton from no rotation, on offset, rotation vector and scale.
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  double scale = 1;
  for (int step = 0; step < 20; ++step) {
    const auto rows = tables.reference.mm.cols();
    Eigen::MatrixXd j(3 * rows, 7);
    Eigen::VectorXd left(3 * rows);
    for (Eigen::Index k = 0; k < rows; ++k) {
      const Eigen::Vector3d turned = rotation * tables.reference.mm.col(k);
      left.segment<3>(3 * k) = tables.other.mm.col(k) - offset - scale * turned;
      j.block<3, 3>(3 * k, 0) = Eigen::Matrix3d::Identity();
      for (Eigen::Index axis = 0; axis < 3; ++axis)
        j.block<3, 1>(3 * k, 3 + axis) =
            scale * Eigen::Vector3d(Eigen::Vector3d::Unit(axis)).cross(turned);
      j.block<3, 1>(3 * k, 6) = turned;
    }
    const Eigen::VectorXd move = j.colPivHouseholderQr().solve(left);
    offset += move.head<3>();
    const Eigen::Vector3d turn = move.segment<3>(3);
    if (turn.norm() > 0)
      rotation = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix() * rotation;
    scale += move[6];
  }
  EXPECT_NEAR(match.scale_ppm, (scale - 1) * 1e6, 1e-5);
  EXPECT_LT((match.offset_nm - offset * 1e6).norm(), 1e-3);
  EXPECT_LT((match.rotation - rotation).norm(), 1e-12);
}

TEST(InstrumentMatch, StatesUncertaintiesThatRepetitionsConfirm) {
  constexpr int kTimes = 400;
  double scale2 = 0, turn2 = 0, offset2 = 0, stated_scale = 0, stated_turn = 0, stated_offset = 0;
  for (int seed = 0; seed < kTimes; ++seed) {
    const auto tables = tables_of({}, 100 + static_cast<std::uint64_t>(seed));
    const auto match = *match_instruments(tables.reference, tables.other, kXyz);
    scale2 += std::pow(match.scale_ppm - 80, 2) / kTimes;
    turn2 += std::pow(match.rotation_arcsec[2] - 500, 2) / kTimes;
    offset2 += std::pow(match.offset_nm[1] + 0.1e6, 2) / kTimes;
    stated_scale += *match.u_scale_ppm / kTimes;
    stated_turn += match.u_rotation_arcsec[2] / kTimes;
    stated_offset += match.u_offset_nm[1] / kTimes;
  }
  // 400 repetitions know a standard deviation to 3.5 %.
  EXPECT_NEAR(std::sqrt(scale2) / stated_scale, 1, 0.12);
  EXPECT_NEAR(std::sqrt(turn2) / stated_turn, 1, 0.12);
  EXPECT_NEAR(std::sqrt(offset2) / stated_offset, 1, 0.12);
}

TEST(InstrumentMatch, WeighsRowsByTheirStatedUncertainty) {
  auto tables = tables_of({.noise_nm = 5}, 3);
  tables.other.u_mm = Eigen::VectorXd::Constant(tables.other.mm.cols(), 5e-6);
  const auto before = *match_instruments(tables.reference, tables.other, kXyz);
  ASSERT_TRUE(before.birge);
  EXPECT_NEAR(*before.birge, 1, 0.1);
  // A row that says of itself that it is bad moves nothing.
  tables.other.mm(0, 124) += 1e-3;
  tables.other.u_mm[124] = 1;
  const auto after = *match_instruments(tables.reference, tables.other, kXyz);
  EXPECT_NEAR(after.scale_ppm, before.scale_ppm, 3 * *before.u_scale_ppm);
}

TEST(InstrumentMatch, NamesTheRowAndTheAxisThatStandOut) {
  auto tables = tables_of({}, 4);
  tables.other.mm(1, 40) += 800e-6;
  const auto match = *match_instruments(tables.reference, tables.other, kXyz);
  ASSERT_FALSE(match.findings.empty());
  EXPECT_THAT(match.findings.back(), HasSubstr("row 41 (y +"));
}

// Where both measured an axis that rests 30 nm on either side, half of the residuals are near 0 and
// half near 60 nm.
TEST(InstrumentMatch, NamesNoRowOfAxesThatRestAtTwoPlaces) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    auto tables = tables_of({.noise_nm = 1}, seed);
    std::mt19937_64 random(seed);
    for (auto* mm : {&tables.reference.mm, &tables.other.mm})
      for (auto& value : mm->reshaped()) value += random() % 2 == 0 ? 30e-6 : -30e-6;
    const auto match = match_instruments(tables.reference, tables.other, kXyz);
    ASSERT_TRUE(match) << match.error().message;
    EXPECT_THAT(match->findings, testing::Not(testing::Contains(HasSubstr("robust"))))
        << "seed " << seed;
  }
}

TEST(InstrumentMatch, SaysThatAFormIsLeft) {
  auto tables = tables_of({.noise_nm = 2}, 5);
  for (Eigen::Index k = 0; k < tables.other.mm.cols(); ++k)
    tables.other.mm(2, k) += 200e-6 * std::sin(0.2 * static_cast<double>(k));
  const auto match = *match_instruments(tables.reference, tables.other, kXyz);
  EXPECT_THAT(match.findings, testing::Contains(HasSubstr("z: residuals keep")));
}

TEST(InstrumentMatch, RefusesRowsThatBelongToNeighbours) {
  auto tables = tables_of({}, 6);
  for (auto& row : tables.other.row) row += 1;
  const auto match = match_instruments(tables.reference, tables.other, kXyz);
  ASSERT_FALSE(match);
  EXPECT_EQ(match.error().reason, "ROWS_SHIFTED");
  EXPECT_THAT(match.error().message, HasSubstr("moved by -1"));
}

TEST(InstrumentMatch, RefusesATableOfOtherRows) {
  auto tables = tables_of({}, 7);
  for (auto& row : tables.other.row) row += 1000;
  EXPECT_EQ(match_instruments(tables.reference, tables.other, kXyz).error().reason,
            "NO_COMMON_ROWS");
  tables.other.row.assign(tables.other.row.size(), 1);
  EXPECT_EQ(match_instruments(tables.reference, tables.other, kXyz).error().reason, "DUPLICATE_ID");
}

TEST(InstrumentMatch, RefusesARotationOfPointsOnALine) {
  auto tables = tables_of({}, 8);
  tables.reference.mm.row(1).setZero();
  tables.reference.mm.row(2).setZero();
  EXPECT_EQ(match_instruments(tables.reference, tables.other, kXyz).error().reason,
            "POINTS_ON_A_LINE");
}

TEST(InstrumentMatch, OfOneAxisIsAStraightLine) {
  auto tables = tables_of({.turn_arcsec = {1, 0, 0}, .noise_nm = 0}, 9);
  Tables one = tables;
  one.reference.mm = tables.reference.mm.row(0).eval();
  one.other.mm = (tables.reference.mm.row(0) * (1 + 12e-6)).array() + 3e-3;
  const auto match = match_instruments(one.reference, one.other, {"x"});
  ASSERT_TRUE(match) << match.error().message;
  EXPECT_NEAR(match->scale_ppm, 12, 1e-6);
  EXPECT_NEAR(match->offset_nm[0], 3000, 1e-6);
  EXPECT_EQ(match->rotation_arcsec.size(), 0);
}

}  // namespace
}  // namespace driftwise::correction
