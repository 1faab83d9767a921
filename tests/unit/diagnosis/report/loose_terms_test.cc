// A formula of the fourth degree on a plan of four or five levels, judged between them.

#include "server/diagnosis/report/loose_terms.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "server/formats/formula/formula.h"

namespace driftwise::diagnosis {
namespace loose_terms_test {
namespace {

// The levels are hit to a hundredth of the stroke: enough that the fourth power is a column of
// its own, and far too little to know its coefficient.
Problem on_levels(int levels, int repeats, const char* formula) {
  Dataset data;
  data.columns = {{{"q1", "mm"}, {}}, {{"x", "mm"}, {}}};
  const auto add = [&](double x, PointSet set) {
    data.time_s.push_back(10.0 * static_cast<double>(data.rows++));
    data.set.push_back(set);
    data.columns[0].values.push_back(x);
    data.columns[1].values.push_back(x);
  };
  for (int repeat = 0; repeat < repeats; ++repeat)
    for (int level = 0; level < levels; ++level)
      add(-1 + 2.0 * level / (levels - 1) + 0.005 * ((repeat * 7 + level * 3) % 5 - 2),
          PointSet::calibration);
  for (int i = 0; i < 40; ++i) add(-0.98 + 0.05 * i, PointSet::validation);
  auto problem = lay_out(data, *formats::Formula::parse(formula)->expand(data), 4000);
  if (!problem) throw std::runtime_error(problem.error().message);
  return std::move(*problem);
}

constexpr auto kFourth = "q1 ~ x + x^2 + x^3 + x^4";

TEST(LooseTerms, OfFourLevelsTheFourthPowerIsOne) {
  const auto loose = loose_terms(on_levels(4, 12, kFourth));
  ASSERT_TRUE(loose);
  EXPECT_THAT(loose->terms, testing::ElementsAre("x^4"));
  EXPECT_GT(loose->with, 1);
  EXPECT_LT(loose->without, 0.5);
  EXPECT_THAT(sentence(*loose), testing::HasSubstr("terms of the baseline: x^4."));
}

TEST(LooseTerms, OfFiveLevelsThereAreNone) { EXPECT_FALSE(loose_terms(on_levels(5, 10, kFourth))); }

TEST(LooseTerms, OfAThirdDegreeOnFourLevelsThereAreNone) {
  EXPECT_FALSE(loose_terms(on_levels(4, 12, "q1 ~ x + x^2 + x^3")));
}

}  // namespace
}  // namespace loose_terms_test
}  // namespace driftwise::diagnosis
