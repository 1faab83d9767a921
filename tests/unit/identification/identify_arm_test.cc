#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "server/identification/identify.h"
#include "tests/unit/identification/robots.h"

namespace driftwise::identification {
namespace {

const IdentifiedParameter& arm_parameter(const Identification& found, const std::string& name) {
  return *std::ranges::find_if(found.parameters,
                               [&](const auto& one) { return one.parameter.name == name; });
}

Identification identified_arm(const Dataset& data, const KinematicsDescription& nominal) {
  IdentifyOptions options;
  options.mechanism = *kinematics::make_mechanism(nominal);
  auto found = identify(data, options);
  EXPECT_TRUE(found) << found.error().message;
  return std::move(*found);
}

// Far from the nominal, and turned in the tracker's frame: what a tracker sees.
KinematicsDescription crooked_arm() {
  auto arm = robots::nominal_arm();
  arm.links[0].a_mm += 0.4;
  arm.links[0].alpha_deg += 0.05;
  arm.links[1].theta_deg -= 0.12;
  arm.links[1].a_mm += 1.3;
  arm.links[1].alpha_deg += 0.08;
  arm.links[1].beta_deg = -0.06;
  arm.links[2].theta_deg += 0.2;
  arm.links[2].a_mm -= 0.9;
  arm.links[2].beta_deg = 0.03;
  arm.links[3].d_mm += 0.7;
  arm.links[3].alpha_deg -= 0.1;
  arm.links[4].theta_deg += 0.15;
  arm.links[4].d_mm -= 0.35;
  arm.frame = {
      .x_mm = 2100, .y_mm = -1500, .z_mm = 60, .rx_deg = 1.2, .ry_deg = -0.8, .rz_deg = 143};
  return arm;
}

TEST(IdentifyArm, RecoversTheLengthsAndAnglesOfASimulatedArm) {
  const auto truth = crooked_arm();
  const Dataset data = robots::arm_campaign(truth, 200, 0, 31);
  const auto found = identified_arm(data, robots::nominal_arm());
  EXPECT_EQ(std::ranges::count(found.free(), 1), 27);  // 4 links + 3 of six, one point measured
  EXPECT_LT(std::sqrt(found.rss.sum() / 600), 1e-7);
  // Those that no gauge touches, by name.
  EXPECT_NEAR(arm_parameter(found, "link1.a_mm").value, 0.4, 1e-5);
  EXPECT_NEAR(arm_parameter(found, "link1.alpha_deg").value, 90.05, 1e-6);
  EXPECT_NEAR(arm_parameter(found, "link2.theta_deg").value, -0.12, 1e-6);
  EXPECT_NEAR(arm_parameter(found, "link2.a_mm").value, -610.7, 1e-5);
  EXPECT_NEAR(arm_parameter(found, "link2.beta_deg").value, -0.06, 1e-6);
  EXPECT_NEAR(arm_parameter(found, "link3.a_mm").value, -573.2, 1e-5);
  EXPECT_NEAR(arm_parameter(found, "link4.d_mm").value, 164.6, 1e-5);
  EXPECT_NEAR(arm_parameter(found, "link5.d_mm").value, 115.35, 1e-5);
  EXPECT_NEAR(arm_parameter(found, "frame.rz_deg").value, 143, 1e-6);
  EXPECT_NEAR(arm_parameter(found, "frame.x_mm").value, 2100, 1e-4);
}

TEST(IdentifyArm, NamesWhatCannotBeToldApart) {
  const auto found =
      identified_arm(robots::arm_campaign(crooked_arm(), 200, 0, 32), robots::nominal_arm());
  EXPECT_FALSE(arm_parameter(found, "link1.theta_deg").free);
  EXPECT_NE(arm_parameter(found, "link1.theta_deg").note.find("frame.rz_deg"), std::string::npos)
      << arm_parameter(found, "link1.theta_deg").note;
  EXPECT_FALSE(arm_parameter(found, "link1.d_mm").free);
  EXPECT_NE(arm_parameter(found, "link1.d_mm").note.find("frame."), std::string::npos);
  EXPECT_FALSE(arm_parameter(found, "link6.d_mm").free);
  EXPECT_EQ(arm_parameter(found, "link6.d_mm").note, "cannot be told apart from tool.z_mm");
  EXPECT_EQ(arm_parameter(found, "link6.d_mm").value, 92.2);
  EXPECT_EQ(arm_parameter(found, "link6.d_mm").standard_error, 0);
}

TEST(IdentifyArm, HoldsWhatTheFileHolds) {
  auto nominal = robots::nominal_arm();
  nominal.hold = {"*.beta_deg"};
  const auto found = identified_arm(robots::arm_campaign(crooked_arm(), 200, 0, 33), nominal);
  EXPECT_EQ(arm_parameter(found, "link2.beta_deg").note, "held by the robot file");
  EXPECT_EQ(arm_parameter(found, "link2.beta_deg").value, 0);
  EXPECT_GT(std::sqrt(found.rss.sum() / 600), 1e-3);  // and pays for it
}

// The six of an arm's frame by name, and where they stand in a description.
struct FrameKey {
  const char* name;
  double FrameDescription::*value;
};
constexpr FrameKey kFrameKeys[] = {
    {"frame.x_mm", &FrameDescription::x_mm},     {"frame.y_mm", &FrameDescription::y_mm},
    {"frame.z_mm", &FrameDescription::z_mm},     {"frame.rx_deg", &FrameDescription::rx_deg},
    {"frame.ry_deg", &FrameDescription::ry_deg}, {"frame.rz_deg", &FrameDescription::rz_deg}};

TEST(IdentifyArm, HoldsEachOfTheFrameAtItsValueAndFitsTheOthers) {
  const auto truth = crooked_arm();
  const Dataset data = robots::arm_campaign(truth, 200, 0, 38);
  for (const auto& key : kFrameKeys) {
    auto nominal = robots::nominal_arm();
    nominal.frame.*key.value = truth.frame.*key.value;
    nominal.hold = {key.name};
    const auto found = identified_arm(data, nominal);
    EXPECT_EQ(arm_parameter(found, key.name).note, "held by the robot file");
    EXPECT_FALSE(arm_parameter(found, key.name).free);
    EXPECT_EQ(arm_parameter(found, key.name).value, truth.frame.*key.value) << key.name;
    EXPECT_LT(std::sqrt(found.rss.sum() / 600), 1e-7) << key.name;
    EXPECT_NEAR(arm_parameter(found, "link2.a_mm").value, -610.7, 1e-5) << key.name;
  }
}

TEST(IdentifyArm, PlacesTheNominalArmWithTwoOfItsFrameHeld) {
  const auto truth = crooked_arm();
  IdentifyOptions options;
  auto nominal = robots::nominal_arm();
  nominal.frame.rz_deg = truth.frame.rz_deg;
  nominal.frame.z_mm = truth.frame.z_mm;
  nominal.hold = {"frame.rz_deg", "frame.z_mm"};
  options.mechanism = *kinematics::make_mechanism(nominal);
  options.placement_only = true;
  const auto placed = identify(robots::arm_campaign(truth, 200, 0, 39), options);
  ASSERT_TRUE(placed) << placed.error().message;
  EXPECT_EQ(placed->unknowns, 4);
  EXPECT_EQ(arm_parameter(*placed, "frame.rz_deg").value, 143);
  EXPECT_EQ(arm_parameter(*placed, "frame.z_mm").value, 60);
  EXPECT_NEAR(arm_parameter(*placed, "frame.x_mm").value, 2100, 10);
  EXPECT_LT(std::sqrt(placed->rss.sum() / 200), 20) << "the arm's own errors";
}

TEST(IdentifyArm, ThePlacementAloneIsTheRigidFitOfTheNominalArm) {
  const Dataset data = robots::arm_campaign(crooked_arm(), 300, 0.05, 34);
  IdentifyOptions options;
  options.mechanism = *kinematics::make_mechanism(robots::nominal_arm());
  options.placement_only = true;
  const auto placed = identify(data, options);
  ASSERT_TRUE(placed) << placed.error().message;
  EXPECT_EQ(placed->unknowns, 6);
  EXPECT_EQ(arm_parameter(*placed, "link2.a_mm").value, -612);
  // The rigid fit is its own minimum: the least squares had nothing left to do.
  EXPECT_LE(placed->evaluations, 4);
}

// Five poses, thirty times each (ISO 9283): fifteen numbers measured, twenty-seven free. The
// joints' readings wander by 1e-5 rad, which makes the rest free in name.
TEST(IdentifyArm, HoldsWhatFivePosesHardlyDetermine) {
  const auto truth = crooked_arm();
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const auto found =
        identified_arm(robots::visits(truth, 5, 30, 0.01, seed), robots::nominal_arm());
    int held = 0;
    for (const auto& one : found.parameters) {
      held += one.note.starts_with("held: these rows determine it") ? 1 : 0;
      if (!one.parameter.placement) {
        EXPECT_LT(std::abs(one.value - one.parameter.nominal), 20) << one.parameter.name;
      }
    }
    EXPECT_GT(held, 0);
    EXPECT_LT(std::sqrt(found.rss.sum() / 450), 0.012);
  }
}

// Statistical, 60 seeds: standard errors are those of the spread over repetitions, and 90 % of the
// intervals hold the truth. Of 60 x 27 dependent intervals the count of one campaign varies; by
// campaign the mean coverage has a standard deviation of about 0.06 / sqrt(60) < 0.01.
TEST(IdentifyArm, StandardErrorsAreHonest) {
  const auto truth = crooked_arm();
  int inside = 0, all = 0;
  for (unsigned seed = 0; seed < 60; ++seed) {
    const auto found =
        identified_arm(robots::arm_campaign(truth, 80, 0.05, 100 + seed), robots::nominal_arm());
    for (const auto& [name, value] :
         std::vector<std::pair<std::string, double>>{{"link1.a_mm", 0.4},
                                                     {"link1.alpha_deg", 90.05},
                                                     {"link2.theta_deg", -0.12},
                                                     {"link2.a_mm", -610.7},
                                                     {"link2.alpha_deg", 0.08},
                                                     {"link2.beta_deg", -0.06},
                                                     {"link3.a_mm", -573.2},
                                                     {"link4.d_mm", 164.6},
                                                     {"link5.d_mm", 115.35}}) {
      const auto& one = arm_parameter(found, name);
      EXPECT_GT(one.standard_error, 0);
      inside += std::abs(one.value - value) < 1.653 * one.standard_error ? 1 : 0;  // t, 213 dof
      ++all;
    }
  }
  const double coverage = static_cast<double>(inside) / all;
  EXPECT_GT(coverage, 0.86) << inside << " of " << all;
  EXPECT_LT(coverage, 0.94) << inside << " of " << all;
}

TEST(IdentifyArm, SaysWhichChannelIsMissing) {
  Dataset data = robots::arm_campaign(crooked_arm(), 20, 0, 35);
  data.columns[4].channel.symbol = "j5";
  IdentifyOptions options;
  options.mechanism = *kinematics::make_mechanism(robots::nominal_arm());
  const auto found = identify(data, options);
  ASSERT_FALSE(found);
  EXPECT_NE(found.error().message.find("needs channel q5_rad, the data have: q1_rad"),
            std::string::npos)
      << found.error().message;
  data.columns[4].channel = {"q5", "deg"};
  EXPECT_EQ(identify(data, options).error().reason, "WRONG_UNIT");
}

// Any numbers of the robot fit as many values as there are unknowns, and nothing says how well.
TEST(IdentifyArm, NeedsMoreValuesThanUnknowns) {
  IdentifyOptions options;
  options.mechanism = *kinematics::make_mechanism(robots::nominal_arm());
  const auto enough = identify(robots::arm_campaign(crooked_arm(), 40, 0, 37), options);
  ASSERT_TRUE(enough) << enough.error().message;
  const auto unknowns = std::ranges::count_if(
      enough->parameters, [](const auto& one) { return one.standard_error > 0; });
  const auto rows = static_cast<int>(unknowns) / 6;  // a pose has six values
  const auto refused = identify(robots::arm_campaign(crooked_arm(), rows, 0, 37), options);
  ASSERT_FALSE(refused) << unknowns << " unknowns, " << rows << " rows";
  EXPECT_EQ(refused.error().reason, "TOO_FEW_ROWS");
  EXPECT_NE(refused.error().message.find("unknowns"), std::string::npos) << refused.error().message;
}

// The tracker set up again 1 mm further on for the later rows: what is served and what a robot file
// says is the geometry alone, so it has to be that of one frame, the first, and not of a mean.
TEST(IdentifyArm, StandsInTheFirstDatumOfItsRows) {
  auto data = robots::arm_campaign(crooked_arm(), 200, 0, 38);
  data.datum.assign(data.rows, 1);
  for (std::size_t row = 130; row < data.rows; ++row) {
    data.datum[row] = 2;
    data.columns[6].values[row] += 1;
    data.columns[8].values[row] -= 0.4;
  }
  const auto found = identified_arm(data, robots::nominal_arm());
  EXPECT_NEAR(arm_parameter(found, "frame.x_mm").value, 2100, 1e-4);
  EXPECT_NEAR(arm_parameter(found, "frame.y_mm").value, -1500, 1e-4);
  ASSERT_EQ(found.terms.size(), 2U);  // the constant, datum(2)
  EXPECT_EQ(found.coefficients.row(0).cwiseAbs().maxCoeff(), 0) << found.coefficients;
  EXPECT_NEAR(found.coefficients(1, 0), 1, 1e-6);
  EXPECT_NEAR(found.coefficients(1, 2), -0.4, 1e-6);
}

// Rows of the second datum say nothing of where the first stands: its standard error is that of its
// own 50 rows, by more than a factor of the 200.
TEST(IdentifyArm, StatesTheUncertaintyOfTheFirstDatumByItsOwnRows) {
  KinematicsDescription nominal = robots::nominal_arm();
  nominal.hold = {"link*", "tool.*", "frame.r*"};
  const double noise_mm = 0.05;
  auto data = robots::arm_campaign(robots::nominal_arm(), 200, noise_mm, 39);
  data.datum.assign(data.rows, 2);
  std::fill_n(data.datum.begin(), 50, 1);
  const auto found = identified_arm(data, nominal);
  // Of 50 rows a part may be slow for all they show; from all 200 it would be half as much.
  const double own_mm = noise_mm / std::sqrt(50);
  EXPECT_GT(arm_parameter(found, "frame.x_mm").standard_error, 0.94 * own_mm);
  EXPECT_LT(arm_parameter(found, "frame.x_mm").standard_error, 1.4 * own_mm);
}

// Scatter of every number over 30 campaigns at the same poses, over the mean of its standard error.
std::vector<double> scatter_over_stated(double sd_z_mm, double phi) {
  const Dataset exact = robots::arm_campaign(crooked_arm(), 150, 0, 40);
  constexpr int kTimes = 30;
  std::mt19937 random(41);
  std::normal_distribution<double> normal;
  std::vector<double> sums, squares, stated;
  for (int time = 0; time < kTimes; ++time) {
    Dataset data = exact;
    for (std::size_t o = 0; o < 3; ++o) {
      double slow = normal(random);
      for (double& value : data.columns[6 + o].values) {
        value += (o == 2 ? sd_z_mm : 0.005) * slow;
        slow = phi * slow + std::sqrt(1 - phi * phi) * normal(random);
      }
    }
    const auto found = identified_arm(data, robots::nominal_arm());
    std::size_t k = 0;
    for (const auto& one : found.parameters) {
      if (!one.free) continue;
      if (k == sums.size()) sums.push_back(0), squares.push_back(0), stated.push_back(0);
      const double value = one.value - one.parameter.nominal;
      sums[k] += value;
      squares[k] += value * value;
      stated[k++] += one.standard_error / kTimes;
    }
  }
  std::vector<double> ratios;
  for (std::size_t k = 0; k < sums.size(); ++k)
    ratios.push_back(std::sqrt((squares[k] - sums[k] * sums[k] / kTimes) / (kTimes - 1)) /
                     stated[k]);
  return ratios;
}

// A tracker that is twenty times worse along the beam: 30 campaigns say a scatter to 13 %.
TEST(IdentifyArm, StatesErrorsByTheNoiseOfEachOutput) {
  for (const double ratio : scatter_over_stated(0.1, 0)) {
    EXPECT_GT(ratio, 0.55);
    EXPECT_LT(ratio, 1.4);
  }
}

// With errors that were independent the frame's position scattered by seven times what was stated.
TEST(IdentifyArm, StatesErrorsOfRowsThatFollowOneAnother) {
  const auto ratios = scatter_over_stated(0.005, 0.95);
  EXPECT_LT(std::ranges::max(ratios), 1.7);
  EXPECT_GT(std::ranges::max(ratios), 0.5);
}

TEST(IdentifyArm, NeedsEnoughRows) {
  IdentifyOptions options;
  options.mechanism = *kinematics::make_mechanism(robots::nominal_arm());
  EXPECT_EQ(identify(robots::arm_campaign(crooked_arm(), 2, 0, 36), options).error().reason,
            "TOO_FEW_ROWS");
}

}  // namespace
}  // namespace driftwise::identification
