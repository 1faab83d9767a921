#include "server/correction/return_subtraction.h"

#include <gtest/gtest.h>

#include <cmath>

namespace driftwise::correction {
namespace {

TEST(ReturnSubtraction, TakesTheLineBetweenTheNeighbouringReturnsOff) {
  JoinPart part;
  part.name = "by hand";
  part.data.rows = 5;
  part.data.time_s = {0, 10, 30, 40, 50};
  part.data.zero = {1, 0, 0, 1, 0};
  part.data.columns = {{{"x", "mm"}, {0.001, 1, 2, 0.005, 3}}};
  ASSERT_TRUE(subtract_returns({0, 3}, part));
  const auto& x = part.data.columns[0].values;
  EXPECT_DOUBLE_EQ(x[1], 1 - (0.001 + 0.004 * 10 / 40));
  EXPECT_DOUBLE_EQ(x[2], 2 - (0.001 + 0.004 * 30 / 40));
  EXPECT_DOUBLE_EQ(x[4], 3 - 0.005);  // after the last return: as there
}

// A single return in a datum is its own centre, and says nothing of its error. Two of them have one
// degree of freedom.
TEST(ReturnSubtraction, KnowsNoSpreadFromOneReturnInEachDatum) {
  JoinPart part;
  part.data.rows = 4;
  part.data.zero = {1, 1, 1, 1};
  part.data.datum = {1, 2, 3, 4};
  part.data.columns = {{{"x", "mm"}, {10e-6, -20e-6, 5e-6, 40e-6}}};
  EXPECT_TRUE(spread_of_returns(part, {0, 1, 2, 3}).empty());
  part.data.datum = {1, 1, 2, 3};
  const auto spread = spread_of_returns(part, {0, 1, 2, 3});
  ASSERT_TRUE(spread.contains("x_mm"));
  EXPECT_NEAR(spread.at("x_mm"), 30e-6 / std::sqrt(2), 1e-12);  // 10 and -20 nm about -5
}

TEST(ReturnSubtraction, AlignsZerosBetweenTheTwoPlacesOfAServo) {
  JoinPart part;
  part.data.columns = {{{"x", "mm"}, {}}};
  std::vector<std::size_t> zeros;
  auto& x = part.data.columns[0].values;
  for (int i = 0; i < 5; ++i) x.insert(x.end(), {30e-6, -30e-6});
  x.push_back(1);
  for (std::size_t row = 0; row < x.size(); ++row) zeros.push_back(row);
  part.data.rows = x.size();
  part.data.zero.assign(x.size(), 1);
  align_zeros(zeros, part);
  // The pairs of 30 with -30 nm are the middle ones; the median is 30 nm.
  EXPECT_NEAR(x[0], 30e-6, 1e-12);
  EXPECT_NEAR(x[1], -30e-6, 1e-12);
}

}  // namespace
}  // namespace driftwise::correction
