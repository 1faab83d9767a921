// The blend of two models of one robot: its weight, its rates and its Jacobian along paths through
// the band, and the check that stands before its promotion.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cstdio>
#include <random>

#include "server/compensation/snapshot_builder.h"
#include "server/plans/band_check.h"
#include "server/plans/joint_target.h"
#include "tests/unit/plans/two_robots.h"

namespace driftwise::plans {
namespace {

using compensation::Variable;
using testing::HasSubstr;

constexpr auto kRx = static_cast<std::size_t>(Variable::rx);
constexpr auto kRy = static_cast<std::size_t>(Variable::ry);
constexpr auto kZ = static_cast<std::size_t>(Variable::z);

JointSnapshot::Robot blended(double turned_arcsec, Blend blend, double fine_reach = 300) {
  ServingPlan plan;
  plan.robots = {{"ma", kFine, std::move(blend), ""}};
  const ModelsById models = {{kFine, min_angle(fine_reach, 4, 0, 1e-4)},
                             {kCoarse, min_angle(18'000, 4, turned_arcsec, 1e-2)}};
  const auto builder = JointBuilder::create(plan, PlanId{1}, models, two_robot_cell());
  if (!builder) throw std::runtime_error(builder.error().message);
  return builder->build(CellTime{1}).robots.front();
}

Blend band_to(double from, double to, bool anchored = false, double fade_to = 0) {
  const std::optional<double> fade = anchored ? std::optional(fade_to) : std::nullopt;
  return {kCoarse, {{Variable::rx, from, to, fade}, {Variable::ry, from, to, fade}}, anchored};
}

Values pose_at(double rx, double ry, double z) {
  Values pose{};
  pose[kRx] = rx;
  pose[kRy] = ry;
  pose[kZ] = z;
  return pose;
}

using Motors = Eigen::Vector3d;
Motors of_blend(const JointSnapshot::Robot& robot, const Values& pose) {
  Motors q;
  robot_coordinates(robot, pose, q.data());
  return q;
}
Motors of_fine(const JointSnapshot::Robot& robot, const Values& pose) {
  Motors q;
  model_coordinates(robot.fine, pose, q.data());
  return q;
}

template <class Give>
Eigen::Matrix3d slopes(const Values& pose, const Give& give) {
  Eigen::Matrix3d out;
  const std::size_t inputs[] = {kRx, kRy, kZ};
  const double steps[] = {1e-3, 1e-3, 1e-6};
  for (int j = 0; j < 3; ++j) {
    Values above = pose, below = pose;
    above[inputs[j]] += steps[j];
    below[inputs[j]] -= steps[j];
    out.col(j) = (give(above) - give(below)) / (2 * steps[j]);
  }
  return out;
}

// What the issue asks along random straight paths: half of them at one height.
struct PathFigures {
  int paths = 0;
  double rate_share = 0, determinant_share = 1e9;
  // docs/plans.md has these figures.
  void print(const char* what) const {
    std::printf("%s: rates off by at most %.3f of the largest, determinant at least %.3f\n", what,
                rate_share, determinant_share);
  }
};
PathFigures along_random_paths(const JointSnapshot::Robot& robot, double box_arcsec, unsigned seed,
                               double lowest_mm = -2.5, double highest_mm = 2.5) {
  std::mt19937_64 random(seed);
  const auto within = [&random](double half) {
    return std::uniform_real_distribution<>(-half, half)(random);
  };
  const auto height = [&] {
    return std::uniform_real_distribution<>(lowest_mm, highest_mm)(random);
  };
  constexpr int kSamples = 200;
  PathFigures out;
  while (out.paths < 1000) {
    const Values from = pose_at(within(box_arcsec), within(box_arcsec), height());
    const Values to =
        pose_at(within(box_arcsec), within(box_arcsec), out.paths % 2 == 0 ? from[kZ] : height());
    const auto at = [&](double s) {
      Values pose{};
      for (const std::size_t v : {kRx, kRy, kZ}) pose[v] = from[v] + s * (to[v] - from[v]);
      return pose;
    };
    bool through = false;
    for (int k = 0; k <= kSamples && !through; ++k) {
      const double w = fine_weight(robot.band, at(k / double{kSamples}));
      through = w > 0 && w < 1;
    }
    if (!through) continue;
    ++out.paths;
    double largest = 0, deviation = 0;
    for (int k = 0; k <= kSamples; ++k) {
      const double s = k / double{kSamples}, h = 1e-6;
      const Motors blend = (of_blend(robot, at(s + h)) - of_blend(robot, at(s - h))) / (2 * h);
      const Motors fine = (of_fine(robot, at(s + h)) - of_fine(robot, at(s - h))) / (2 * h);
      largest = std::max(largest, fine.cwiseAbs().maxCoeff());
      deviation = std::max(deviation, (blend - fine).cwiseAbs().maxCoeff());
      if (k % 4 != 0) continue;
      const double share =
          slopes(at(s), [&](const Values& p) { return of_blend(robot, p); }).determinant() /
          slopes(at(s), [&](const Values& p) { return of_fine(robot, p); }).determinant();
      out.determinant_share = std::min(out.determinant_share, share);
    }
    out.rate_share = std::max(out.rate_share, deviation / largest);
  }
  return out;
}

TEST(SmoothStep, HasNoKinkInItsFirstTwoDerivatives) {
  EXPECT_EQ(smooth_step(-1), 0);
  EXPECT_EQ(smooth_step(0), 0);
  EXPECT_DOUBLE_EQ(smooth_step(0.5), 0.5);
  EXPECT_EQ(smooth_step(1), 1);
  EXPECT_EQ(smooth_step(2), 1);
  // Second differences across the ends, and the largest slope, by their definition.
  const double h = 1e-4;
  for (const double end : {0.0, 1.0}) {
    EXPECT_NEAR((smooth_step(end + h) - smooth_step(end - h)) / (2 * h), 0, 1e-7);
    EXPECT_NEAR((smooth_step(end + h) - 2 * smooth_step(end) + smooth_step(end - h)) / (h * h), 0,
                1e-2);
  }
  EXPECT_NEAR((smooth_step(0.5 + h) - smooth_step(0.5 - h)) / (2 * h), kSteepestStep, 1e-6);
}

TEST(FineWeight, IsOneUpToTheBandAndNothingBeyond) {
  const auto robot = blended(3, study_band());
  EXPECT_EQ(fine_weight(robot.band, pose_at(300, -300, 0)), 1);
  EXPECT_EQ(fine_weight(robot.band, pose_at(350, 0, 0)), 0);
  EXPECT_EQ(fine_weight(robot.band, pose_at(0, -351, 0)), 0);
  EXPECT_DOUBLE_EQ(fine_weight(robot.band, pose_at(-325, 0, 0)), 0.5);
  EXPECT_DOUBLE_EQ(fine_weight(robot.band, pose_at(325, 325, 0)), 0.25);
}

TEST(FineWeight, EndsInHeightToo) {
  auto blend = study_band();
  blend.band.push_back({Variable::z, 2.9, 3.0, {}});
  const auto robot = blended(3, blend);
  EXPECT_EQ(fine_weight(robot.band, pose_at(0, 0, 2.9)), 1);
  EXPECT_NEAR(fine_weight(robot.band, pose_at(0, 0, -2.95)), 0.5, 1e-12);
  EXPECT_EQ(fine_weight(robot.band, pose_at(0, 0, 3.0)), 0);
}

// Fitted to z from 0 to 3 mm: from its middle on both sides, or from zero on one.
TEST(FineWeight, CountsFromACentreAndOnOneSide) {
  auto blend = study_band();
  blend.band.push_back({Variable::z, 1.4, 1.5, {}, 1.5});
  const auto centred = blended(3, blend);
  EXPECT_EQ(fine_weight(centred.band, pose_at(0, 0, 0.1)), 1);
  EXPECT_EQ(fine_weight(centred.band, pose_at(0, 0, 2.9)), 1);
  EXPECT_NEAR(fine_weight(centred.band, pose_at(0, 0, 0.05)), 0.5, 1e-12);
  EXPECT_NEAR(fine_weight(centred.band, pose_at(0, 0, 2.95)), 0.5, 1e-12);
  EXPECT_EQ(fine_weight(centred.band, pose_at(0, 0, -0.001)), 0);
  EXPECT_EQ(fine_weight(centred.band, pose_at(0, 0, 3.001)), 0);
  blend.band.back() = {Variable::z, 2.9, 3.0, {}, 0, BandSide::above};
  const auto above = blended(3, blend);
  EXPECT_EQ(fine_weight(above.band, pose_at(0, 0, -3.5)), 1)
      << "the other side is the fine model's";
  EXPECT_NEAR(fine_weight(above.band, pose_at(0, 0, 2.95)), 0.5, 1e-12);
  EXPECT_EQ(fine_weight(above.band, pose_at(0, 0, 3.001)), 0);
  blend.band.back() = {Variable::z, 2.9, 3.0, {}, 0, BandSide::below};
  const auto below = blended(3, blend);
  EXPECT_EQ(fine_weight(below.band, pose_at(0, 0, 3.5)), 1);
  EXPECT_NEAR(fine_weight(below.band, pose_at(0, 0, -2.95)), 0.5, 1e-12);
}

TEST(HeldAtBorder, StandsHalfwayBeyondOnTheSideThatCounts) {
  auto blend = band_to(300, 350, true, 1500);
  blend.band.push_back({Variable::z, 1.4, 1.5, 2, 1.5});
  const auto centred = blended(3, blend);
  EXPECT_DOUBLE_EQ(held_at_border(centred.band, pose_at(0, 0, 1))[kZ], 1);
  EXPECT_DOUBLE_EQ(held_at_border(centred.band, pose_at(0, 0, 3.4))[kZ], 2.95);
  EXPECT_NEAR(held_at_border(centred.band, pose_at(0, 0, -0.3))[kZ], 0.05, 1e-12);
  blend.band.back() = {Variable::z, 2.9, 3.0, 3.6, 0, BandSide::above};
  const auto above = blended(3, blend);
  EXPECT_DOUBLE_EQ(held_at_border(above.band, pose_at(0, 0, 3.4))[kZ], 2.95);
  EXPECT_DOUBLE_EQ(held_at_border(above.band, pose_at(0, 0, -3.4))[kZ], -3.4);
}

// The fine model with z from 0 to 3 mm, the coarse one from coarse_min_z to 4.
JointSnapshot::Robot blended_above_zero(double turned_arcsec, Blend blend, double coarse_min_z) {
  ServingPlan plan;
  plan.robots = {{"ma", kFine, std::move(blend), ""}};
  ModelsById models = {{kFine, min_angle(300, 3, 0, 1e-4)},
                       {kCoarse, min_angle(18'000, 4, turned_arcsec, 1e-2)}};
  models[kFine].domain.back().min = 0;
  models[kCoarse].domain.back().min = coarse_min_z;
  const auto builder = JointBuilder::create(plan, PlanId{1}, models, two_robot_cell());
  if (!builder) throw std::runtime_error(builder.error().message);
  return builder->build(CellTime{1}).robots.front();
}

TEST(Blend, OfAHeightFromZeroKeepsRatesAndJacobianOnOneSideAndAboutItsMiddle) {
  auto one_sided = study_band(), centred = study_band();
  one_sided.band.push_back({Variable::z, 2.5, 3.0, {}, 0, BandSide::above});
  centred.band.push_back({Variable::z, 1.2, 1.5, {}, 1.5});
  for (const auto& [blend, coarse_min] : {std::pair{one_sided, 0.0}, std::pair{centred, -4.0}}) {
    const auto robot = blended_above_zero(3, blend, coarse_min);
    const auto report = check_band(robot);
    EXPECT_TRUE(report.accepted()) << sentence_of(report);
    const auto seen = along_random_paths(robot, 450, 5, 0, 3.5);
    seen.print("z from 0 to 3 mm");
    EXPECT_LT(seen.rate_share, 0.5);
    EXPECT_GT(seen.determinant_share, 0.5);
    EXPECT_LT(seen.rate_share, 1.1 * report.rate_share);
    EXPECT_FALSE(check_band(blended_above_zero(200, blend, coarse_min)).accepted());
  }
}

TEST(HeldAtBorder, FollowsThePoseInsideAndStandsHalfwayBeyond) {
  const auto robot = blended(3, band_to(300, 350, true, 1500));
  EXPECT_EQ(held_at_border(robot.band, pose_at(299, -10, 1)), pose_at(299, -10, 1));
  EXPECT_DOUBLE_EQ(held_at_border(robot.band, pose_at(-350, 0, 0))[kRx], -325);
  EXPECT_DOUBLE_EQ(held_at_border(robot.band, pose_at(5000, 0, 0))[kRx], 325);
}

TEST(Blend, OfModelsThatAgreeKeepsRatesAndJacobianAlongThousandPaths) {
  const auto robot = blended(3, study_band());
  const auto report = check_band(robot);
  EXPECT_TRUE(report.accepted()) << sentence_of(report);
  EXPECT_NEAR(report.difference_arcsec, 3, 0.02);
  const auto seen = along_random_paths(robot, 450, 1);
  EXPECT_EQ(seen.paths, 1000);
  seen.print("3 arcsec apart");
  EXPECT_LT(seen.rate_share, 0.5);
  EXPECT_GT(seen.determinant_share, 0.5);
  // The check looks at a grid: it sees what the paths see, to a tenth.
  EXPECT_LT(seen.rate_share, 1.1 * report.rate_share);
}

TEST(Blend, OfModelsTwoHundredArcsecApartIsRefusedWithThePlace) {
  const auto report = check_band(blended(200, study_band()));
  EXPECT_FALSE(report.accepted());
  EXPECT_NEAR(report.difference_arcsec, 200, 1);
  // 200 arcsec at 60 mm, seen by the axis that rx moves most.
  double most = 0;
  for (int i = 0; i < 3; ++i) most = std::max(most, std::abs(std::sin(axis_angle(i))));
  EXPECT_NEAR(report.largest_difference_nm, 1e6 * kRadius_mm * 200 * kRadOfArcsec * most, 100);
  // A weight that ends within 50 arcsec: rates off by 15/8 * 200/50 and more, of 0.5 accepted.
  EXPECT_GT(report.rate_share, 5);
  EXPECT_THAT(sentence_of(report), HasSubstr("arcsec) at ma.z_mm = "));
  EXPECT_THAT(sentence_of(report), HasSubstr("anchored = true with fade_to = "));
  ASSERT_TRUE(report.anchored_fade_to);
  EXPECT_FALSE(report.wider_to) << "the fine model was fitted to 300 arcsec";
  const auto seen = along_random_paths(blended(200, study_band()), 450, 2);
  EXPECT_GT(seen.rate_share, 0.5) << "what is refused would indeed be wrong";
  seen.print("200 arcsec apart, refused");
}

TEST(Blend, OfTheSameModelsIsAcceptedWithTheAnchorThatTheRefusalOffers) {
  const auto refused = check_band(blended(200, study_band()));
  ASSERT_TRUE(refused.anchored_fade_to);
  const double fade_to = *refused.anchored_fade_to;
  const auto robot = blended(200, band_to(300, 350, true, fade_to));
  const auto report = check_band(robot);
  EXPECT_TRUE(report.accepted()) << sentence_of(report);
  for (const double box : {450.0, fade_to}) {
    const auto seen = along_random_paths(robot, box, 3);
    seen.print("200 arcsec apart, anchored");
    EXPECT_LT(seen.rate_share, 0.5) << box;
    EXPECT_GT(seen.determinant_share, 0.5) << box;
  }
  // Where the shift has ended the coarse model answers as fitted.
  Motors coarse;
  const Values far = pose_at(fade_to + 1, 0, 1);
  model_coordinates(*robot.coarse, far, coarse.data());
  EXPECT_TRUE(of_blend(robot, far).isApprox(coarse, 1e-14));
}

TEST(Blend, OfTheSameModelsIsAcceptedWithTheWiderBandWhereTheFineModelReachesFar) {
  const auto refused = check_band(blended(200, study_band(), 1500));
  ASSERT_FALSE(refused.accepted());
  ASSERT_TRUE(refused.wider_to);
  const auto robot = blended(200, band_to(300, *refused.wider_to), 1500);
  EXPECT_TRUE(check_band(robot).accepted());
  const auto seen = along_random_paths(robot, *refused.wider_to, 4);
  seen.print("200 arcsec apart, wider band");
  EXPECT_LT(seen.rate_share, 0.5);
  EXPECT_GT(seen.determinant_share, 0.5);
}

// Six coordinates and six motors, each a little of everything; the coarse model is off by a random
// polynomial of the second degree, bend_mm at the ends of its range.
JointSnapshot::Robot blended_in(std::size_t parts, unsigned seed, double bend_mm) {
  constexpr Variable kCoordinates[] = {Variable::x,  Variable::y,  Variable::z,
                                       Variable::rx, Variable::ry, Variable::rz};
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<> off(-1, 1);
  const auto half = [](std::size_t c) { return c < 3 ? 1.0 : 100.0; };
  const auto name = [&](std::size_t c) { return compensation::channel_of(kCoordinates[c]).symbol; };
  const auto model = [&](double times, double bend) {
    calibration::Model made;
    for (std::size_t o = 0; o < 6; ++o) {
      calibration::OutputModel q;
      q.channel = {"q" + std::to_string(o + 1), "mm"};
      std::vector<double> coefficients;
      for (std::size_t c = 0; c < 6; ++c) {
        q.terms.push_back({{effects::Power{name(c)}}});
        coefficients.push_back((o == c ? 1 : 0.01) / half(c));
      }
      for (std::size_t a = 0; a < 6; ++a)
        for (std::size_t b = a; b < 6; ++b) {
          q.terms.push_back(
              a == b ? effects::Term{{effects::Power{name(a), 2}}}
                     : effects::Term{{effects::Power{name(a)}, {effects::Power{name(b)}}}});
          coefficients.push_back(bend * off(random) / half(a) / half(b));
        }
      const auto n = static_cast<Eigen::Index>(coefficients.size());
      q.coefficients = Eigen::Map<Eigen::VectorXd>(coefficients.data(), n);
      q.covariance = Eigen::MatrixXd::Identity(n, n) * 1e-12;
      q.dof = 100;
      q.accuracy.rmse = 1e-5;
      made.outputs.push_back(std::move(q));
    }
    for (std::size_t c = 0; c < 6; ++c)
      made.domain.push_back(
          {compensation::channel_of(kCoordinates[c]), -times * half(c), times * half(c)});
    return made;
  };
  const auto snapshot_of = [](const calibration::Model& of) {
    auto builder = compensation::SnapshotBuilder::create(of, ModelId{1}, CellDescription{});
    if (!builder) throw std::runtime_error(builder.error().message);
    builder->keep_model_datum();
    return builder->build(CellTime{1'000'000'000'000});
  };
  JointSnapshot::Robot robot;
  robot.fine = snapshot_of(model(1, 0));
  robot.coarse = snapshot_of(model(4, bend_mm));
  robot.needed = robot.fine.needed;
  robot.same_terms = true;
  robot.band.parts = parts;
  for (std::size_t p = 0; p < parts; ++p)
    robot.band.part[p] = {kCoordinates[p], 0.6 * half(p), 0.9 * half(p), 0.9 * half(p), 0,
                          BandSide::both};
  return robot;
}

TEST(BandPart, OfTheGridFindsTheWorstOfTheWhole) {
  for (const unsigned seed : {1u, 2u}) {
    const auto robot = blended_in(2, seed, 0.01);
    const auto whole = check_band(robot), part = check_band(robot, 3000);
    EXPECT_TRUE(whole.whole_grid);
    EXPECT_FALSE(part.whole_grid);
    EXPECT_LE(part.poses, 3000);
    EXPECT_GT(whole.poses, 3 * part.poses);
    // The fine model is straight here, so that both count in the same largest rates.
    EXPECT_NEAR(part.rate_share, whole.rate_share, 0.01 * whole.rate_share) << seed;
    EXPECT_NEAR(*part.determinant_share, *whole.determinant_share, 0.005) << seed;
    EXPECT_NEAR(part.largest_difference_nm, whole.largest_difference_nm,
                0.02 * whole.largest_difference_nm);
  }
}

TEST(BandPart, OfSixCoordinatesIsLookedAtWithinTheNumberOfPosesAndSaysSo) {
  constexpr std::int64_t kFew = 8000;  // kMostPoses in a test of a second
  const auto agree = check_band(blended_in(6, 1, 1e-4), kFew);
  EXPECT_TRUE(agree.accepted()) << sentence_of(agree);
  EXPECT_LE(agree.poses, kFew);
  EXPECT_THAT(sentence_of(agree), HasSubstr("a part of the grid"));
  const auto apart = check_band(blended_in(6, 1, 0.2), kFew);
  EXPECT_FALSE(apart.accepted()) << sentence_of(apart);
  EXPECT_LE(apart.poses, kFew);
}

}  // namespace
}  // namespace driftwise::plans
