// Errors of an arm's joints on a plant of its own: four joints whose points, masses and torques are
// trigonometry written out here, in another form than the daemon's chain of links.

#include "server/diagnosis/robot/arm_diagnosis.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <numbers>
#include <random>

#include "server/diagnosis/robot/robot_diagnosis.h"
#include "server/formats/cell_file/kinematics_section.h"
#include "server/formats/csv/dataset_csv.h"
#include "tests/unit/diagnosis/robots/finding_names.h"

namespace driftwise::diagnosis {
namespace {

constexpr double kArcsec = std::numbers::pi / 648000;

// Column, shoulder offset, upper arm, forearm, hand; joint 1 turns about the vertical, the others
// lift in the plane of the arm.
constexpr double kHeight = 420, kOffset = 150, kUpper = 700, kFore = 650, kHand = 140;  // mm
constexpr double kUsual_degC = 21;  // of the room: the mean over a campaign
constexpr double kUpper_kg = 22, kFore_kg = 9, kHand_kg = 2, kLoad_kg = 4;

struct HiddenInJoints {
  double shoulder_urad_per_newton_m = 0, elbow_urad_per_newton_m = 0;
  double gear_arcsec = 0, gear_phase = 0.7;  // joint 1, once per turn
  double gear_twice_arcsec = 0;              // joint 1, twice per turn
  double elbow_gear_arcsec = 0;              // joint 3, twice per turn
  double play_arcsec = 0;                    // joint 3
  double turn_play_arcsec = 0;               // joint 1: the side that it came from
  double drift_arcsec_per_k = 0;             // joint 2, with t03
  double upper_arm_mm = 0;                   // longer than drawn
};

struct Angles {
  double turn, shoulder, elbow, hand;
};

struct Torques {  // N m, positive where they lift
  double shoulder, elbow;
};

// Each part's weight times its horizontal distance; its centre is at the middle of it.
Torques torques(const Angles& q) {
  constexpr double g = 9.80665, metre = 1e-3;
  const double c2 = kUpper * metre * std::cos(q.shoulder);
  const double c3 = kFore * metre * std::cos(q.shoulder + q.elbow);
  const double c4 = kHand * metre * std::cos(q.shoulder + q.elbow + q.hand);
  const double elbow = -g * (kFore_kg * c3 / 2 + kHand_kg * (c3 + c4 / 2) + kLoad_kg * (c3 + c4));
  return {elbow - g * (kUpper_kg * c2 / 2 + (kFore_kg + kHand_kg + kLoad_kg) * c2), elbow};
}

std::array<double, 3> point(Angles q, const HiddenInJoints& hidden, double t03) {
  const Torques by = torques(q);
  q.turn += hidden.gear_arcsec * kArcsec * std::cos(q.turn - hidden.gear_phase) +
            hidden.gear_twice_arcsec * kArcsec * std::cos(2 * q.turn + 0.3);
  q.shoulder += hidden.shoulder_urad_per_newton_m * 1e-6 * by.shoulder +
                hidden.drift_arcsec_per_k * kArcsec * (t03 - kUsual_degC);
  q.elbow += hidden.elbow_urad_per_newton_m * 1e-6 * by.elbow +
             hidden.play_arcsec / 2 * kArcsec * (by.elbow > 0 ? 1 : -1) +
             hidden.elbow_gear_arcsec * kArcsec * std::sin(2 * q.elbow + 0.4);
  const double lift3 = q.shoulder + q.elbow, lift4 = lift3 + q.hand;
  const double upper = kUpper + hidden.upper_arm_mm;
  const double out =
      kOffset + upper * std::cos(q.shoulder) + kFore * std::cos(lift3) + kHand * std::cos(lift4);
  return {
      out * std::cos(q.turn), out * std::sin(q.turn),
      kHeight + upper * std::sin(q.shoulder) + kFore * std::sin(lift3) + kHand * std::sin(lift4)};
}

// reach: share of the joints' ranges that is used. warms_up: the room, instead of going up and
// down.
Dataset campaign(const HiddenInJoints& hidden, std::uint64_t seed, double reach = 1,
                 std::size_t rows = 400, double noise_mm = 0.02, bool warms_up = false) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> turn(-2.9, 2.9), lift(-0.4, 2.2), bend(-2.4, 2.4),
      hand(-2.6, 2.6);
  Dataset data;
  data.rows = rows;
  for (const char* name :
       {"q1_deg", "q2_deg", "q3_deg", "q4_deg", "t03_degC", "x_mm", "y_mm", "z_mm"})
    data.columns.push_back({*parse_channel(name), {}});
  double slow = 0, turned_from = 0;
  for (std::size_t i = 0; i < rows; ++i) {
    const double time_s = 12.0 * static_cast<double>(i);
    const double room = warms_up ? 5 * (1 - std::exp(-time_s / 900)) : 1.8 * std::sin(time_s / 700);
    const double t03 = 21 + room + 0.003 * normal(random);
    const Angles q{reach * turn(random), reach * lift(random), reach * bend(random),
                   reach * hand(random)};
    slow = 0.9 * slow + 0.006 * normal(random);
    Angles behind_play = q;
    behind_play.turn -= hidden.turn_play_arcsec / 2 * kArcsec * (q.turn > turned_from ? 1 : -1);
    turned_from = q.turn;
    const auto at = point(behind_play, hidden, t03);
    const double given[] = {q.turn, q.shoulder, q.elbow, q.hand};
    data.time_s.push_back(time_s);
    for (std::size_t k = 0; k < 4; ++k)
      data.columns[k].values.push_back(given[k] * 180 / std::numbers::pi);
    data.columns[4].values.push_back(t03);
    for (std::size_t k = 0; k < 3; ++k)
      data.columns[5 + k].values.push_back(at[k] + noise_mm * normal(random) + slow);
  }
  return data;
}

KinematicsDescription drawing(bool masses) {
  KinematicsDescription arm;
  arm.kind = "serial-arm";
  arm.links = {{{"q1", "deg"}, 0, kHeight, kOffset, 90, 0},
               {{"q2", "deg"}, 0, 0, kUpper, 0, 0},
               {{"q3", "deg"}, 0, 0, kFore, 0, 0},
               {{"q4", "deg"}, 0, 0, kHand, 0, 0}};
  if (!masses) return arm;
  const auto weigh = [&arm](std::size_t link, double kg, double centre_mm) {
    arm.links[link].mass_kg = kg;
    arm.links[link].mass_centre_mm = {centre_mm, 0, 0};
  };
  weigh(1, kUpper_kg, -kUpper / 2);
  weigh(2, kFore_kg, -kFore / 2);
  weigh(3, kHand_kg, -kHand / 2);
  arm.tool_mass_kg = kLoad_kg;
  return arm;
}

RobotDiagnosis diagnosed_within(double reach, const HiddenInJoints& hidden, std::uint64_t seed,
                                bool masses = false) {
  auto found = diagnose_robot(campaign(hidden, seed, reach),
                              *kinematics::make_mechanism(drawing(masses)), {});
  EXPECT_TRUE(found) << found.error().message;
  return std::move(*found);
}

RobotDiagnosis diagnosed(const HiddenInJoints& hidden, std::uint64_t seed, bool masses = false) {
  return diagnosed_within(1, hidden, seed, masses);
}

// Beside the numbers of the drawing. What the prior takes from a sag or a drift may stand as a
// small offset of the same joint: it is less than the noise of a row.
std::vector<std::string> joint_names(const Diagnosis& diagnosis) {
  constexpr double kRowNoise_nm = 20e3;
  std::vector<std::string> all;
  for (const auto& finding : diagnosis.findings) {
    if (finding.cause != "geometry_parameter") {
      all.push_back(finding.cause + " " + finding.subject);
      continue;
    }
    for (const auto& output : finding.outputs)
      EXPECT_LT(output.amplitude, kRowNoise_nm) << finding.sentence;
  }
  std::ranges::sort(all);
  return all;
}

const FoundParameter& number_of(const Diagnosis& diagnosis, const std::string& cause,
                                const std::string& parameter) {
  static const FoundParameter none{.name = "none"};
  for (const auto& finding : diagnosis.findings)
    if (finding.cause == cause)
      for (const auto& one : finding.parameters)
        if (one.name == parameter) return one;
  return none;
}

TEST(ArmDiagnosis, FindsTheStiffnessOfJointsWhoseLoadIsKnown) {
  const auto found =
      diagnosed({.shoulder_urad_per_newton_m = 6, .elbow_urad_per_newton_m = 15}, 21, true);
  EXPECT_EQ(joint_names(found.diagnosis),
            (Names{"joint_compliance joint2", "joint_compliance joint3"}));
  for (const auto& finding : found.diagnosis.findings) {
    if (finding.cause != "joint_compliance") continue;
    const auto& sag = finding.parameters.front();
    EXPECT_EQ(sag.name, "sag_urad_per_newton_m");
    const double truth = finding.subject == "joint2" ? 6 : 15;
    EXPECT_NEAR(sag.value, truth, 2.5 * (sag.ci90->high - sag.value)) << finding.sentence;
    ASSERT_TRUE(finding.outputs[2].a90_after);
    EXPECT_LT(*finding.outputs[2].a90_after, *finding.outputs[2].a90_before);
  }
  EXPECT_NEAR(found.robot.links[1].errors.sag_urad_per_newton_m, 6, 0.6);
}

TEST(ArmDiagnosis, FindsSagOfJointsWhoseLoadIsNotKnown) {
  const auto found =
      diagnosed({.shoulder_urad_per_newton_m = 6, .elbow_urad_per_newton_m = 15}, 22);
  const auto named = names(found.diagnosis);
  EXPECT_TRUE(std::ranges::count(named, "joint_compliance joint2"));
  EXPECT_TRUE(std::ranges::count(named, "joint_compliance joint3"));
  EXPECT_GT(found.robot.links[1].errors.sag_urad_per_m, 0);
}

TEST(ArmDiagnosis, FindsAnEccentricWheelBesideALengthThatIsWrong) {
  const auto found = diagnosed({.gear_arcsec = 60, .upper_arm_mm = 0.4}, 23);
  EXPECT_EQ(names(found.diagnosis), (Names{"gear_error joint1", "geometry_parameter link2.a"}));
  const auto& size = number_of(found.diagnosis, "gear_error", "amplitude_arcsec");
  EXPECT_NEAR(size.value, 60, 2.5 * (size.ci90->high - size.value));
  EXPECT_NEAR(found.robot.links[1].a_mm, kUpper + 0.4, 0.03);
}

TEST(ArmDiagnosis, FindsPlayByTheSignOfGravitysTorque) {
  const auto found = diagnosed({.play_arcsec = 45}, 24);
  EXPECT_EQ(names(found.diagnosis), Names{"backlash joint3"});
  const auto& width = number_of(found.diagnosis, "backlash", "width_arcsec");
  EXPECT_NEAR(width.value, 45, 3 * (width.ci90->high - width.value));
}

// The column turns about the vertical: gravity chooses no flank.
TEST(ArmDiagnosis, FindsPlayByTheSideThatTheJointCameFrom) {
  const auto found = diagnosed({.turn_play_arcsec = 45, .upper_arm_mm = 0.4}, 34);
  EXPECT_EQ(names(found.diagnosis), (Names{"backlash joint1", "geometry_parameter link2.a"}));
  const auto& width = number_of(found.diagnosis, "backlash", "width_by_motion_arcsec");
  EXPECT_NEAR(width.value, 45, 3 * (width.ci90->high - width.value));
  EXPECT_EQ(found.robot.links[0].errors, JointErrors{});
  EXPECT_NEAR(found.robot.links[1].a_mm, kUpper + 0.4, 0.03);
  // Figures include the play, which no robot file can have.
  for (const std::size_t o : {0, 1}) {
    const auto& output = found.diagnosis.outputs[o];
    EXPECT_LT(output.u90_calibration_after, 1.645 * 1.25 * 24e3) << output.output;
  }
}

TEST(ArmDiagnosis, FindsAJointsZeroThatMovesWithTheTemperature) {
  const auto found = diagnosed({.drift_arcsec_per_k = 8}, 25);
  EXPECT_EQ(joint_names(found.diagnosis), Names{"joint_offset_drift joint2 t03"});
  const auto& drift = number_of(found.diagnosis, "joint_offset_drift", "drift_arcsec_per_k");
  EXPECT_NEAR(drift.value, 8, 2.5 * (drift.ci90->high - drift.value));
  EXPECT_EQ(found.robot.links[1].errors.drift_channel.name(), "t03_degC");
}

// A mount that gives way moves a joint by more than the expansion of any metal does.
TEST(ArmDiagnosis, FindsAJointsZeroThatMovesFarMoreThanMetalGrows) {
  const auto found = diagnosed({.drift_arcsec_per_k = 140}, 33);
  EXPECT_EQ(joint_names(found.diagnosis), Names{"joint_offset_drift joint2 t03"});
  EXPECT_NEAR(number_of(found.diagnosis, "joint_offset_drift", "drift_arcsec_per_k").value, 140, 4);
}

// Most poses see the warm end only; the few cold ones say most of the drift.
TEST(ArmDiagnosis, FindsAJointsZeroThatMovesWhileTheRoomWarmsUp) {
  for (const double drift : {6.0, 60.0}) {
    const auto found =
        diagnose_robot(campaign({.drift_arcsec_per_k = drift}, 35, 1, 150, 0.02, true),
                       *kinematics::make_mechanism(drawing(false)), {});
    ASSERT_TRUE(found) << found.error().message;
    const auto named = names(found->diagnosis);
    EXPECT_TRUE(std::ranges::count(named, "joint_offset_drift joint2 t03")) << drift;
    const auto& size = number_of(found->diagnosis, "joint_offset_drift", "drift_arcsec_per_k");
    EXPECT_NEAR(size.value, drift, 3 * (size.ci90->high - size.value));
  }
}

// Sag of millimetres at the tool, and a wheel of 0.1 mm: what the sag explains is no noise.
TEST(ArmDiagnosis, FindsWhatStandsInTheShadowOfAStrongSag) {
  int both = 0;
  for (std::uint64_t seed = 60; seed < 64; ++seed) {
    const auto found =
        diagnosed({.shoulder_urad_per_newton_m = 8, .elbow_gear_arcsec = 22}, seed, true);
    const auto named = joint_names(found.diagnosis);
    both += std::ranges::count(named, "joint_compliance joint2") == 1 &&
            std::ranges::count(named, "gear_error joint3") == 1 && named.size() == 2;
  }
  EXPECT_EQ(both, 4);
}

// A tracker that lost its beam for one pose: with that row in, the drawing's numbers go where it
// is.
TEST(ArmDiagnosis, IdentifiesTheRobotWithoutTheRowsThatAreWrong) {
  for (const double wrong_mm : {20.0, 5000.0}) {
    auto data = campaign({.upper_arm_mm = 0.4}, 31, 1, 150);
    data.columns[7].values[5] += wrong_mm;
    const auto found = diagnose_robot(data, *kinematics::make_mechanism(drawing(false)), {});
    ASSERT_TRUE(found) << found.error().message;
    const auto outliers = std::ranges::find(found->diagnosis.findings, "outliers", &Finding::cause);
    ASSERT_NE(outliers, found->diagnosis.findings.end());
    EXPECT_EQ(outliers->rows, std::vector<std::size_t>{5});
    EXPECT_NEAR(found->robot.links[1].a_mm, kUpper + 0.4, 0.05) << wrong_mm;
    for (const auto& figure : found->diagnosis.outputs)
      EXPECT_LT(figure.a90_validation_after.value_or(HUGE_VAL), 1e5)
          << "nm: of readings with 0.02 mm of noise, " << wrong_mm;
  }
}

TEST(ArmDiagnosis, NamesNothingOfAnArmAsDrawn) {
  int named = 0;
  for (std::uint64_t seed = 200; seed < 208; ++seed)
    named += diagnosed({}, seed).diagnosis.findings.empty() ? 0 : 1;
  EXPECT_EQ(named, 0);
}

// The shoulder of such arms turns a third of a circle, and most joints less than two thirds.
TEST(ArmDiagnosis, FindsGearErrorsOfJointsThatTurnLessThanOnce) {
  const auto found = diagnosed_within(0.5, {.gear_arcsec = 60}, 30);
  EXPECT_EQ(joint_names(found.diagnosis), Names{"gear_error joint1"});
  const auto twice = diagnosed_within(0.5, {.elbow_gear_arcsec = 40}, 31);
  EXPECT_EQ(joint_names(twice.diagnosis), Names{"gear_error joint3"});
}

// Ninety poses of a tracker. Either error alone predicts no rows left out: what the other leaves
// goes with the angle as well.
TEST(ArmDiagnosis, FindsTwoErrorsOfOneGear) {
  int both = 0;
  for (std::uint64_t seed = 41; seed <= 45; ++seed) {
    const auto found =
        diagnose_robot(campaign({.gear_arcsec = 60, .gear_twice_arcsec = 60}, seed, 1, 90, 0.08),
                       *kinematics::make_mechanism(drawing(false)), {});
    ASSERT_TRUE(found) << found.error().message;
    both += names(found->diagnosis) == Names{"gear_error joint1", "gear_error joint1"} ? 1 : 0;
  }
  EXPECT_GE(both, 4);
}

TEST(ArmDiagnosis, SaysFromWhichSizeOnAGearErrorWouldShow) {
  const auto found = diagnosed_within(0.1, {}, 209);
  EXPECT_EQ(joint_names(found.diagnosis), Names{});
  std::string why;
  for (const auto& one : found.diagnosis.not_testable)
    if (one.cause == "gear_error joint2 harmonic 1") why = one.why;
  EXPECT_NE(why.find("these rows show it from"), std::string::npos) << why;
}

// The arm that it writes leaves nothing more to be found of its joints.
TEST(ArmDiagnosis, IsDoneOnceItsRobotFileIsTheDrawing) {
  const HiddenInJoints hidden{.shoulder_urad_per_newton_m = 6, .gear_arcsec = 60};
  const auto found = diagnosed(hidden, 26, true);
  const auto text = formats::write_robot_file(found.robot);
  const auto written = formats::parse_robot_file(text, "identified.toml");
  ASSERT_TRUE(written) << written.error().message << text;
  const auto again =
      diagnose_robot(campaign(hidden, 26), *kinematics::make_mechanism(*written), {});
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(names(again->diagnosis), Names{});
}

}  // namespace
}  // namespace driftwise::diagnosis
