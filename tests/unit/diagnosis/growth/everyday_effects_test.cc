// Effects as they come: two lost fringes in one night, a lever under a tilt that scatters, a wave
// that the places cannot tell from others.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/diagnosis/diagnosed.h"
#include "tests/unit/diagnosis/everyday_axis.h"

namespace driftwise::diagnosis {
namespace {

using ::testing::ElementsAre;

TEST(TwoJumps, AreBothNamedWhateverTheirSigns) {
  for (const double second_mm : {60e-6, -60e-6, 150e-6}) {
    EverydayAxis axis(1);
    for (std::size_t row = 0; row < EverydayAxis::kRows; ++row)
      axis.x_mm[row] += (row >= 150 ? 60e-6 : 0) + (row >= 333 ? second_mm : 0);
    const auto found = axis.diagnosed();
    ASSERT_THAT(names_found(found), ElementsAre("step_change x")) << second_mm;
    std::vector<double> instants_s;
    for (const auto& parameter : found.findings[0].parameters)
      if (parameter.name.ends_with("time_s")) instants_s.push_back(parameter.value);
    std::ranges::sort(instants_s);
    ASSERT_EQ(instants_s.size(), 2U) << second_mm;
    EXPECT_NEAR(instants_s[0], axis.time_s[150], 60);
    EXPECT_NEAR(instants_s[1], axis.time_s[333], 60);
    EXPECT_EQ(found.verdict, Verdict::extended);
  }
}

// The motor is the output: its model has the jump with the opposite sign.
TEST(AJump, HasTheSignOfWhatIsReadOfTheCoordinate) {
  for (const double jump_mm : {150e-6, -150e-6}) {
    EverydayAxis axis(1);
    for (std::size_t row = 200; row < EverydayAxis::kRows; ++row) axis.x_mm[row] += jump_mm;
    const auto found = axis.diagnosed();
    ASSERT_THAT(names_found(found), ElementsAre("step_change x"));
    const auto& parameters = found.findings[0].parameters;
    const auto size = std::ranges::find(parameters, "size_nm", &FoundParameter::name);
    ASSERT_NE(size, parameters.end()) << found.findings[0].sentence;
    EXPECT_NEAR(size->value, 1e6 * jump_mm, 30);
  }
}

// Every move is far longer than the play: what the readings have is its step, so that the width
// of the term is what the step says, and the term is served with it.
TEST(APlayShorterThanEveryMove, HasTheWidthThatItsStepHas) {
  for (const double play_mm : {60e-6, 300e-6}) {
    EverydayAxis axis(3);
    double behind_mm = axis.q_mm.front();  // what the motor pushes, within the play
    for (std::size_t row = 0; row < EverydayAxis::kRows; ++row) {
      const double q_mm = axis.q_mm[row];
      behind_mm = std::clamp(behind_mm, q_mm - play_mm / 2, q_mm + play_mm / 2);
      axis.x_mm[row] += behind_mm - q_mm;
    }
    const auto found = axis.diagnosed();
    ASSERT_EQ(names_found(found).at(0), "backlash q1");
    const auto& finding = found.findings.front();
    ASSERT_EQ(finding.terms.size(), 1U);
    const auto& call = std::get<effects::Call>(finding.terms.front().factors.front());
    const double width_nm = call.parameters.front().value;
    EXPECT_NEAR(width_nm, 1e6 * play_mm, 0.05e6 * play_mm);
    ASSERT_EQ(finding.outputs.front().coefficients.size(), 1U);
    EXPECT_NEAR(std::abs(finding.outputs.front().coefficients.front()), 1, 0.05);
  }
}

// A block that was measured 600 nm off: the hour tells it, so that it is no tip's other side.
TEST(ABlockOfRowsThatIsOff, HasTwoJumpsAndNoHysteresis) {
  EverydayAxis axis(2);
  for (std::size_t row = 150; row < 333; ++row) axis.x_mm[row] += 600e-6;
  EXPECT_THAT(names_found(axis.diagnosed()), ElementsAre("step_change x"));
}

// A dial read by hand for an afternoon: it drifts by 25 standard deviations while the room warms.
TEST(AnInstrumentThatDrifts, IsNotTakenForTheRoomThatWarmsMeanwhile) {
  int drift = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    Dataset data;
    std::vector<double> t01, d;
    for (std::size_t row = 0; row < 60; ++row) {
      const double hour = static_cast<double>(row) / 30;
      data.time_s.push_back(3600 * hour);
      t01.push_back(21 + 1.5 * (1 - std::exp(-hour / 0.8)) + 0.02 * normal(random));
      d.push_back(12.5 * hour * 0.2 + 0.2 * normal(random));
    }
    data.rows = 60;
    data.columns = {{{"t01", "degC"}, t01}, {{"d", "um"}, d}};
    const auto found = diagnosed(data, "d ~ 1");
    ASSERT_EQ(found.findings.size(), 1U) << seed;
    drift += found.findings[0].cause == "instrument_drift" ? 1 : 0;
  }
  EXPECT_GE(drift, 9);
}

// 12 mm of lever: the measured pose scatters with the tilt, and geometry of that pose would know
// it.
TEST(ALever, IsNamedHoweverMuchTheTiltScatters) {
  for (const double scatter_arcsec : {0.5, 2.0, 5.0}) {
    EverydayAxis axis(3);
    std::mt19937_64 random(4);
    std::normal_distribution<double> normal;
    for (std::size_t row = 0; row < EverydayAxis::kRows; ++row) {
      axis.ry_arcsec.push_back(scatter_arcsec * normal(random));
      axis.x_mm[row] += 12 * axis.ry_arcsec[row] * std::numbers::pi / 648000;
    }
    const auto found = axis.diagnosed();
    ASSERT_THAT(names_found(found), ElementsAre("abbe_offset x")) << scatter_arcsec;
    EXPECT_NEAR(found.findings[0].parameters[0].value, 12, 0.2);
  }
}

// Targets that are whole multiples of 10 um: on them a wave of 10.0001 um, of a scale, is one slow
// turn over the stroke, and as smooth as the rail.
TEST(ABentRail, IsNoWaveOfAScale) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> off(-0.5, 0.5);
    std::vector<double> targets;
    for (int k = 0; k < 21; ++k)
      targets.push_back(0.01 * std::round(100 * (40.0 * k + (k % 20 == 0 ? 0 : 8 * off(random)))));
    Dataset data;
    std::vector<double> q, x;
    for (std::size_t row = 0; row < 400; ++row) {
      const std::size_t k = row % 40;
      const double at = targets[k < 21 ? k : 40 - k], u = at / 400 - 1;
      data.time_s.push_back(12.0 * static_cast<double>(row));
      q.push_back(at);
      x.push_back(at + 1e-3 * (1.5 * (u * u * u - 0.6 * u) + 0.35 * normal(random)));
    }
    data.rows = data.time_s.size();
    data.columns = {{{"q1", "mm"}, q}, {{"x", "mm"}, x}};
    EXPECT_THAT(names_found(diagnosed(data, "q1 ~ x")), ElementsAre("geometry_order x")) << seed;
  }
}

// A grid plate under two slides: the guide of the second bends, and moves x by 100 nm within each
// column of marks. A wave of half a micrometre along x has that bend in its phase, and no more.
TEST(AGuideThatBends, IsNoWaveOfTheOtherAxis) {
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    Dataset data;
    std::vector<double> q1, q2, x, y;
    for (std::size_t row = 0; row < 300; ++row) {
      const std::size_t column = row / 10 % 10, line = row % 10;
      q1.push_back(17.0 * static_cast<double>(column));
      q2.push_back(17.0 * static_cast<double>(column % 2 == 0 ? line : 9 - line));
      const double u = q2.back() / 76.5 - 1;
      x.push_back(q1.back() + 1e-4 * (2 * u * u - u) + 2e-5 * normal(random));
      y.push_back(q2.back() + 2e-5 * normal(random));
      data.time_s.push_back(3.0 * static_cast<double>(row));
    }
    data.rows = data.time_s.size();
    data.columns = {{{"q1", "mm"}, q1}, {{"q2", "mm"}, q2}, {{"x", "mm"}, x}, {{"y", "mm"}, y}};
    const auto found = diagnosed(data, "q1 ~ x + x^2");
    for (const auto& finding : found.findings)
      EXPECT_NE(finding.cause, "cyclic_error") << seed << " " << finding.sentence;
    ASSERT_FALSE(found.findings.empty()) << seed;
    EXPECT_EQ(found.findings[0].cause + " " + found.findings[0].subject, "geometry_order y");
  }
}

// A table that is divided in 36, each way, its disk 2 arcsec off its centre: readings against the
// encoder, and deviations with no other coordinate than the encoder's. What is found may be a
// little more than a turn.
struct Table {
  bool deviations = false;
  double twice_arcsec = 0;  // of a disk that is elliptic, too

  Diagnosis diagnosed(std::uint64_t seed) const {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    Dataset data;
    std::vector<double> q_arcsec, read_arcsec;
    for (std::size_t row = 0; row < 296; ++row) {
      const std::size_t k = row % 74;
      const double at = 36000.0 * static_cast<double>(k < 37 ? k : 73 - k) + 300 * normal(random);
      const double turns = at / 1296000;
      const double error = 2 * std::sin(2 * std::numbers::pi * turns + 0.7) +
                           twice_arcsec * std::cos(4 * std::numbers::pi * turns - 0.4) +
                           0.15 * normal(random);
      data.time_s.push_back(20.0 * static_cast<double>(row));
      q_arcsec.push_back(at);
      read_arcsec.push_back(deviations ? error : at + error);
    }
    data.rows = data.time_s.size();
    data.columns = {{{"q1", "arcsec"}, q_arcsec},
                    {{deviations ? "e" : "rz", "arcsec"}, read_arcsec}};
    return diagnosis::diagnosed(data, deviations ? "e ~ 1" : "q1 ~ rz");
  }
};

TEST(AnEccentricTable, ErrsOnceATurn) {
  int longer = 0;
  for (const std::uint64_t seed : {8, 9, 10, 11, 12, 13}) {
    const bool deviations = seed % 2 == 1;
    const auto found = Table{.deviations = deviations}.diagnosed(seed);
    ASSERT_THAT(names_found(found),
                ElementsAre(deviations ? "cyclic_error q1" : "cyclic_error rz"));
    EXPECT_NEAR(found.findings[0].parameters[0].value, 1296000, 0.02 * 1296000) << deviations;
    longer += found.findings[0].parameters[0].value > 1296000 ? 1 : 0;
  }
  EXPECT_GT(longer, 0);
}

// All around, a power of the angle does not come back to where it was.
TEST(AnEccentricTable, HasWavesAndNoGeometryOfHigherOrder) {
  const auto found = Table{.deviations = true, .twice_arcsec = 0.7}.diagnosed(14);
  ASSERT_THAT(names_found(found), ElementsAre("cyclic_error q1"));
  std::vector<double> turns;
  for (const auto& parameter : found.findings[0].parameters)
    if (parameter.name.ends_with("period_arcsec")) turns.push_back(1296000 / parameter.value);
  std::ranges::sort(turns);
  ASSERT_EQ(turns.size(), 2U);
  EXPECT_NEAR(turns[0], 1, 0.03);
  EXPECT_NEAR(turns[1], 2, 0.06);
}

// The first of six legs loses counts: x, y, z and the rotations are all elsewhere from then on.
TEST(AJumpOfOneLegOfSix, IsThatLegs) {
  constexpr std::size_t kPoses = 300;
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> even(-1, 1);
  const std::vector<std::pair<std::string, std::string>> pose = {
      {"x", "mm"}, {"y", "mm"}, {"z", "mm"}, {"rx", "arcsec"}, {"ry", "arcsec"}, {"rz", "arcsec"}};
  Eigen::Matrix<double, 6, 6> legs;
  for (double& one : legs.reshaped()) one = even(random);
  legs.rightCols<3>() *= 1e-3;  // mm per arcsec
  Dataset data;
  data.rows = kPoses;
  data.columns.resize(12);
  for (std::size_t k = 0; k < 6; ++k) {
    data.columns[k].channel = {pose[k].first, pose[k].second};
    data.columns[6 + k].channel = {"q" + std::to_string(k + 1), "mm"};
  }
  for (std::size_t row = 0; row < kPoses; ++row) {
    data.time_s.push_back(40.0 * static_cast<double>(row));
    Eigen::Vector<double, 6> at;
    for (std::size_t k = 0; k < 6; ++k) {
      at[static_cast<Eigen::Index>(k)] = (k < 3 ? 1 : 100) * even(random);
      data.columns[k].values.push_back(at[static_cast<Eigen::Index>(k)]);
    }
    const Eigen::Vector<double, 6> q_mm = legs * at;
    for (std::size_t k = 0; k < 6; ++k)
      data.columns[6 + k].values.push_back(q_mm[static_cast<Eigen::Index>(k)] +
                                           20e-6 * normal(random) +
                                           (k == 0 && row >= 200 ? 100e-6 : 0));
  }
  EXPECT_THAT(names_found(diagnosed(data, "q ~ x + y + z + rx + ry + rz")),
              ElementsAre("step_change q1"));
}

// A beam that begins 500 mm before x = 0 and stands square: the path on a mirror that turns by up
// to 60 arcsec is (x + 500 mm)(1 - cos).
TEST(ABeamOnAMirrorThatTurns, HasTheLengthOfItsPath) {
  EverydayAxis axis(6);
  for (std::size_t row = 0; row < EverydayAxis::kRows; ++row) {
    axis.ry_arcsec.push_back(60 * std::sin(axis.time_s[row] / 5000));
    const double angle = axis.ry_arcsec[row] * std::numbers::pi / 648000;
    axis.x_mm[row] += (axis.q_mm[row] + 500) * (1 - std::cos(angle));
  }
  const auto found = axis.diagnosed();
  ASSERT_THAT(names_found(found), ElementsAre("cosine_error x"));
  EXPECT_EQ(found.findings[0].parameters[0].name, "dead_path_mm");
  EXPECT_NEAR(found.findings[0].parameters[0].value, 500, 50);
}

// A wave of 0.8 mm read every 0.25 mm.
TEST(AWave, StatesThePeriodsThatThePlacesCannotTellFromIt) {
  EverydayAxis axis(5);
  for (std::size_t row = 0; row < EverydayAxis::kRows; ++row)
    axis.x_mm[row] += 15e-6 * std::sin(2 * std::numbers::pi * axis.q_mm[row] / 0.8);
  const auto found = axis.diagnosed();
  ASSERT_EQ(found.findings.size(), 1U);
  EXPECT_EQ(found.findings[0].cause, "cyclic_error");
  const auto& period = found.findings[0].parameters[0];
  auto all = period.aliases;
  all.push_back(period.value);
  EXPECT_THAT(all, testing::Contains(testing::DoubleNear(800e3, 20e3)));
}

}  // namespace
}  // namespace driftwise::diagnosis
