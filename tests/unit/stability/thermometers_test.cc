#include "server/stability/thermometers.h"

#include <gtest/gtest.h>

#include "tests/unit/stability/noise.h"

namespace driftwise::tests {
namespace {

using stability::compare_thermometers;
using stability::Thermometer;

// Six thermometers in one bath that warms by 0.05 K/h; the third reads 60 mK high.
std::vector<Thermometer> bath() {
  std::vector<Thermometer> out;
  for (unsigned k = 0; k < 6; ++k) {
    Thermometer one{"t0" + std::to_string(k + 1) + "_degC", 0.005, {}};
    one.series.time_s = times(360, 10);
    one.series.values = white_noise(360, 0.002, 40 + k);
    for (std::size_t i = 0; i < 360; ++i)
      one.series.values[i] += 20 + 0.05 * one.series.time_s[i] / 3600 + (k == 2 ? 0.06 : 0);
    out.push_back(std::move(one));
  }
  return out;
}

TEST(Thermometers, FindsTheOneThatReadsHigh) {
  const auto found = compare_thermometers(bath(), 60);
  EXPECT_EQ(found.blocks, 60U);
  EXPECT_NEAR(found.common_drift_k_per_h, 0.05, 0.002);
  ASSERT_EQ(found.offsets.size(), 6U);
  for (const auto& one : found.offsets)
    EXPECT_EQ(one.out, one.channel == "t03_degC") << one.channel;
  // Of a mean that it does not belong to.
  EXPECT_NEAR(found.offsets[2].offset_k, 0.06, 0.001);
  EXPECT_LT(found.offsets[2].u_offset_k, 0.001);
  EXPECT_NEAR(found.offsets[0].drift_k_per_h, 0, 0.002);
}

TEST(Thermometers, AnOffsetWithinTheCertificatesIsNotOut) {
  auto thermometers = bath();
  for (auto& one : thermometers) one.u_certificate_k = 0.05;
  for (const auto& one : compare_thermometers(thermometers, 60).offsets) EXPECT_FALSE(one.out);
}

TEST(Thermometers, CountsOnlyBlocksThatAllHave) {
  auto thermometers = bath();
  auto& short_one = thermometers[4].series;
  short_one.time_s.resize(30);  // five minutes
  short_one.values.resize(30);
  const auto found = compare_thermometers(thermometers, 60);
  EXPECT_EQ(found.blocks, 5U);
  EXPECT_TRUE(found.offsets.empty());
}

// Two agree, two do not: offsets and mean are those of the two that agree.
TEST(Thermometers, CountsAllOffsetsFromTheOnesThatAgree) {
  auto four = bath();
  four.resize(4);
  for (double& value : four[2].series.values) value += 0.04;  // 0.1 in all
  for (double& value : four[3].series.values) value += 0.2;
  const auto found = compare_thermometers(four, 60);
  ASSERT_EQ(found.offsets.size(), 4U);
  const double offsets_k[] = {0, 0, 0.1, 0.2};
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_NEAR(found.offsets[k].offset_k, offsets_k[k], 0.001);
    EXPECT_EQ(found.offsets[k].out, k > 1) << k;
  }
  EXPECT_NEAR(found.offsets[0].offset_k + found.offsets[1].offset_k, 0, 1e-9);
}

// Of two, nobody can say which is right.
TEST(Thermometers, TakesTheMeanOfTwoThatDisagree) {
  auto two = bath();
  two.resize(2);
  for (double& value : two[1].series.values) value += 0.2;
  const auto found = compare_thermometers(two, 60);
  ASSERT_EQ(found.offsets.size(), 2U);
  EXPECT_NEAR(found.offsets[0].offset_k, -0.1, 0.001);
  EXPECT_NEAR(found.offsets[1].offset_k, 0.1, 0.001);
  EXPECT_TRUE(found.offsets[0].out && found.offsets[1].out);
}

}  // namespace
}  // namespace driftwise::tests
