// Several runs that measured one length and do not agree: what the join says of it.

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "server/correction/dataset_join.h"

namespace driftwise::correction {
namespace {

using testing::HasSubstr;

// x of 72 poses and 8 returns to zero; off_nm: at the poses alone, as a probe's dry friction is.
JoinPart probed(const char* name, double off_nm, double noise_nm, unsigned seed) {
  std::mt19937 random(seed), plan(5);
  std::normal_distribution<double> noise(0, noise_nm);
  std::uniform_real_distribution<double> place(-2, 2);
  JoinPart part;
  part.name = name;
  auto& data = part.data;
  data.columns = {{{"q1", "mm"}, {}}, {{"x", "mm"}, {}}};
  for (std::size_t row = 0; row < 80; ++row) {
    const bool zero = row % 10 == 0;
    const double q_mm = zero ? 0 : place(plan);
    data.time_s.push_back(10.0 * static_cast<double>(row));
    data.zero.push_back(zero ? 1 : 0);
    data.columns[0].values.push_back(q_mm);
    data.columns[1].values.push_back(q_mm + 1e-6 * (noise(random) + (zero ? 0 : off_nm)));
  }
  data.rows = 80;
  return part;
}

// Axes of a servo rest 30 nm on either side of where they were sent, and the scale repeats to 3 nm:
// differences of two runs lie at 0 and at +-60 nm, half and half.
constexpr double kRest_nm = 30;

// With x of 8 lines of 12 places, the last of each at zero; symbols: of its coordinates, of which a
// run on one axis has the first.
JoinPart rested(const char* name, std::vector<std::string> symbols, unsigned seed) {
  constexpr double kPlaces_mm[] = {0.3, 1.1, 0.7, 1.9, 2.3, 1.5, 0.1, 2.7, 1.3, 2.1, 0.9, 0};
  std::mt19937 random(seed);
  std::normal_distribution<double> repeats_nm(0, 3), instrument_nm(0, 2);
  JoinPart part;
  part.name = name;
  auto& data = part.data;
  data.columns = {{{"q1", "mm"}, {}}, {{"q2", "mm"}, {}}};
  for (auto& symbol : symbols) data.columns.push_back({{std::move(symbol), "mm"}, {}});
  const auto at_rest_mm = [&] {
    const double side_nm = random() % 2 == 0 ? -kRest_nm : kRest_nm;
    return 1e-6 * (side_nm + repeats_nm(random));
  };
  for (std::size_t row = 0; row < 96; ++row) {
    const double place_mm = kPlaces_mm[row % 12];
    const double q1_mm = place_mm + at_rest_mm(), q2_mm = at_rest_mm();
    data.time_s.push_back(30.0 * static_cast<double>(row));
    data.zero.push_back(place_mm == 0 ? 1 : 0);
    data.columns[0].values.push_back(q1_mm);
    data.columns[1].values.push_back(q2_mm);
    for (std::size_t c = 2; c < data.columns.size(); ++c) {
      const bool is_x = data.columns[c].channel.symbol == "x";
      data.columns[c].values.push_back((is_x ? q1_mm : q2_mm) * 1.0001 +
                                       1e-6 * instrument_nm(random));
    }
  }
  data.rows = 96;
  return part;
}

TEST(JoinDifference, OfAxesThatRestAtTwoPlacesRefusesNoGoodRuns) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    const auto joined = join({rested("a", {"x"}, 2 * seed), rested("b", {"y"}, 2 * seed + 1)}, {});
    EXPECT_TRUE(joined) << "seed " << seed << ": " << joined.error().message;
  }
}

// Two runs differ by hypot(30, 30) nm and what the instruments repeat to.
TEST(JoinDifference, OfAxesThatRestAtTwoPlacesHasOneUncertainty) {
  const double of_one_nm = std::sqrt(kRest_nm * kRest_nm + 3.0 * 3.0 + 2.0 * 2.0);
  for (unsigned seed = 0; seed < 24; ++seed) {
    const auto joined = join({rested("a", {"x"}, 2 * seed), rested("b", {"x"}, 2 * seed + 1)}, {});
    ASSERT_TRUE(joined) << "seed " << seed << ": " << joined.error().message;
    const auto& channels = joined->report.channels;
    const auto x = std::ranges::find_if(
        channels, [](const JoinedChannel& one) { return one.channel.symbol == "x"; });
    ASSERT_TRUE(x != channels.end() && x->check && x->u);
    const double sigma_nm = of_one_nm * std::sqrt(2.0);
    EXPECT_NEAR(1e6 * x->check->sigma, sigma_nm, 0.2 * sigma_nm) << "seed " << seed;
    // Of the mean of two, and as much for where each run stood from the mean place of the motors;
    // with eight returns the zeros of the two are apart by some 15 nm.
    const double u_nm =
        std::hypot(sigma_nm / 2, 1e6 * x->check->median / 2, kRest_nm / std::sqrt(2.0));
    EXPECT_NEAR(1e6 * *x->u, u_nm, 0.2 * u_nm) << "seed " << seed;
  }
}

// A row that is missing in the middle leaves the rows before it as they were.
TEST(JoinDifference, IsSeenAsShiftedWhenOnlyTheLaterRowsAre) {
  auto a = rested("a", {"x"}, 1), b = rested("b", {"x"}, 2);
  constexpr std::size_t kGone = 33;  // a third: most rows are behind it
  for (auto& column : b.data.columns) {
    column.values.erase(column.values.begin() + kGone);
    column.values.push_back(column.values.back());
  }
  const auto joined = join({a, b}, {.max_zero_difference_mm = 10});
  ASSERT_FALSE(joined);
  EXPECT_EQ(joined.error().reason, "ROWS_SHIFTED") << joined.error().message;
}

// The pair that scatters most is not the one that differs most.
TEST(JoinDifference, CountsAConstantDifferenceAsOneThatScatters) {
  const auto joined =
      join({probed("a", 0, 15, 1), probed("b", 0, 15, 2), probed("c", 1000, 5, 3)}, {});
  ASSERT_TRUE(joined) << joined.error().message;
  const auto& channels = joined->report.channels;
  const auto x = std::ranges::find_if(
      channels, [](const JoinedChannel& one) { return one.channel.symbol == "x"; });
  ASSERT_NE(x, channels.end());
  ASSERT_TRUE(x->check && x->u);
  EXPECT_EQ(x->check->second, "c");
  EXPECT_NEAR(std::abs(x->check->median), 1e-3, 3e-5);
  EXPECT_NEAR(*x->u, 1e-3 / std::sqrt(6.0), 2e-5);  // 1000 nm of two, in the mean of three
  EXPECT_THAT(joined->report.warnings,
              testing::Contains(testing::AllOf(HasSubstr(" and c differs by "),
                                               HasSubstr("times what their returns to zero say"))));
  const auto two = join({probed("a", 0, 15, 1), probed("b", 1000, 15, 2)}, {});
  ASSERT_TRUE(two) << two.error().message;
  EXPECT_THAT(two->report.warnings, testing::Contains(HasSubstr("x_mm of a and b differs by ")));
}

}  // namespace
}  // namespace driftwise::correction
