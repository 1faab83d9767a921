// Channels under names of the user's own: their place in the formula gives them their role.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "server/diagnosis/stand_ins.h"
#include "tests/unit/diagnosis/diagnosed.h"
#include "tests/unit/diagnosis/everyday_axis.h"

namespace driftwise::diagnosis {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

Dataset under_own_names(Dataset data) {
  data.columns[0].channel.symbol = "drive";
  data.columns[1].channel.symbol = "probe";
  return data;
}

Diagnosis of_own_names(const Dataset& data) {
  return diagnosed(under_own_names(data), "drive ~ probe + probe^2 + T");
}

std::vector<std::string> causes_not_asked(const Diagnosis& found) {
  std::vector<std::string> causes;
  for (const auto& one : found.not_testable) causes.push_back(one.cause);
  return causes;
}

// A wave of 15 nm, a play of 200 nm.
std::vector<EverydayAxis> hidden() {
  EverydayAxis wave(5), play(3);
  double behind_mm = play.q_mm.front() - 100e-6;
  for (std::size_t row = 0; row < EverydayAxis::kRows; ++row) {
    wave.x_mm[row] += 15e-6 * std::sin(2 * std::numbers::pi * wave.q_mm[row] / 0.8);
    behind_mm = std::clamp(behind_mm, play.q_mm[row] - 100e-6, play.q_mm[row] + 100e-6);
    play.x_mm[row] += behind_mm - play.q_mm[row];
  }
  return {wave, play};
}

TEST(ChannelsUnderOwnNames, HaveTheCausesThatTheyHaveUnderTheUsualOnes) {
  for (const auto& axis : hidden()) {
    const auto usual = axis.diagnosed(), own = of_own_names(axis.dataset());
    ASSERT_FALSE(usual.findings.empty());
    ASSERT_EQ(own.findings.size(), usual.findings.size()) << usual.findings[0].cause;
    EXPECT_EQ(own.findings[0].cause, usual.findings[0].cause);
    EXPECT_EQ(own.findings[0].log_likelihood_ratio, usual.findings[0].log_likelihood_ratio);
    EXPECT_EQ(own.verdict, usual.verdict);
    EXPECT_EQ(causes_not_asked(own), causes_not_asked(usual));
    EXPECT_EQ(own.outputs.size(), usual.outputs.size());
    for (const auto& output : own.outputs) EXPECT_EQ(output.output, "drive");
    EXPECT_EQ(own.findings[0].outputs.size(), usual.findings[0].outputs.size());
    for (const auto& output : own.findings[0].outputs) EXPECT_EQ(output.output, "drive");
    EXPECT_THAT(own.extended_formula, HasSubstr("drive ~ probe + probe^2"));
    EXPECT_THAT(own.warnings, Contains(HasSubstr("drive counts as q1")));
  }
}

TEST(ChannelsUnderOwnNames, AreAdequateWhereNothingIsHidden) {
  const auto found = of_own_names(EverydayAxis(11).dataset());
  EXPECT_THAT(names_found(found), ElementsAre());
  EXPECT_EQ(found.verdict, Verdict::adequate);
}

// A deviation of 10 um beside 2.5 mm is no motor, a tilt of seconds no coordinate.
TEST(ChannelsUnderOwnNames, ThatAreDeviationsOrTiltsKeepThem) {
  EverydayAxis axis(6);
  Dataset data = axis.dataset();
  auto& deviation = data.columns[1];
  for (std::size_t row = 0; row < data.rows; ++row)
    deviation.values[row] = 1e3 * (axis.x_mm[row] - axis.q_mm[row]);
  deviation.channel = {"deviation", "um"};
  DiagnoseOptions options;
  options.baseline = *formats::Formula::parse("deviation ~ q1 + q1^2")->expand(data);
  EXPECT_FALSE(in_names_of_coordinates(data, options));
  data.columns.push_back({{"pitch", "arcsec"}, {}});
  for (std::size_t row = 0; row < data.rows; ++row)
    data.columns.back().values.push_back(0.1 * static_cast<double>(row % 40));
  options.baseline = *formats::Formula::parse("deviation ~ q1 + pitch")->expand(data);
  EXPECT_FALSE(in_names_of_coordinates(data, options));
}

TEST(ChannelsUnderOwnNames, ThatNoCauseReadsAreSaid) {
  EverydayAxis axis(7);
  Dataset data = axis.dataset();
  data.columns.push_back({{"pitch", "arcsec"}, {}});
  for (std::size_t row = 0; row < data.rows; ++row)
    data.columns.back().values.push_back(2 * std::sin(axis.time_s[row] / 5000));
  EXPECT_THAT(diagnosed(data, "q1 ~ x + x^2 + T").warnings,
              Contains(HasSubstr("no cause reads pitch (arcsec)")));
  EXPECT_THAT(axis.diagnosed().warnings, Not(Contains(HasSubstr("no cause reads"))));
}

TEST(ACyclicError, IsListedAsNotAskedWhereNoCoordinateVaries) {
  EverydayAxis axis(8);
  Dataset data = axis.dataset();
  data.columns.erase(data.columns.begin());
  data.columns[0].channel = {"d", "um"};
  for (std::size_t row = 0; row < data.rows; ++row)
    data.columns[0].values[row] = 1e3 * (axis.x_mm[row] - axis.q_mm[row]);
  EXPECT_THAT(causes_not_asked(diagnosed(data, "d ~ T")), Contains("cyclic_error"));
}

}  // namespace
}  // namespace driftwise::diagnosis
