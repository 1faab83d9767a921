// A load that is on or off: F, F^2 and F^(2/3) are one column. The name is the linear one, with the
// others in its set, for half of the load gives half of the displacement as far as anybody knows.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/unit/diagnosis/diagnosed.h"

namespace driftwise::diagnosis {
namespace load_of_two_levels_test {
namespace {

// What the load does, in nm: of the share of the largest load that is on.
template <typename Law>
Dataset loaded(unsigned seed, std::size_t levels, const Law& law) {
  constexpr double kLargest_n = 5, kLoadCell_n = 0.01;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Dataset data;
  data.rows = 200;
  data.columns = {{{"q1", "mm"}, {}}, {{"x", "mm"}, {}}, {{"force", "N"}, {}}};
  for (std::size_t i = 0; i < data.rows; ++i) {
    const double x = 5.0 * static_cast<double>(random() % 11);
    const double share = static_cast<double>(random() % levels) / static_cast<double>(levels - 1);
    data.time_s.push_back(30.0 * static_cast<double>(i));
    data.columns[0].values.push_back(x + 1e-6 * (law(share) + 10 * normal(random)));
    data.columns[1].values.push_back(x);
    data.columns[2].values.push_back(kLargest_n * share + kLoadCell_n * normal(random));
  }
  return data;
}

TEST(LoadOfTwoLevels, IsALinearComplianceWithTheOtherLawsInItsSet) {
  for (unsigned seed = 1; seed <= 3; ++seed)
    for (const double size_nm : {20.0, 30.0, 60.0}) {
      const auto found =
          diagnosed(loaded(seed, 2, [&](double share) { return size_nm * share; }), "q1 ~ x + x^2");
      ASSERT_EQ(found.findings.size(), 1U) << seed;
      EXPECT_EQ(found.findings[0].cause, "force_compliance") << seed << ", " << size_nm;
      EXPECT_THAT(found.findings[0].indistinguishable_from,
                  testing::Contains("force_nonlinearity F"))
          << seed;
    }
}

TEST(LoadOfFiveLevels, ThatActsByItsSquareIsNotCalledLinear) {
  const auto found =
      diagnosed(loaded(4, 5, [](double share) { return 60 * share * share; }), "q1 ~ x + x^2");
  ASSERT_EQ(found.findings.size(), 1U);
  EXPECT_EQ(found.findings[0].cause, "force_nonlinearity");
}

}  // namespace
}  // namespace load_of_two_levels_test
}  // namespace driftwise::diagnosis
