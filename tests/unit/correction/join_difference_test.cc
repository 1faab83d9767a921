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
