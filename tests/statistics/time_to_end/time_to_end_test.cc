// The short version of the count in docs/evidence/time_to_end.md.

#include <gtest/gtest.h>
#include <spdlog/spdlog.h>

#include "tests/statistics/time_to_end/restless_cell.h"

namespace driftwise::tests {
namespace {

TEST(TimeToEnd, LiesInTheStatedBandAboutAsOftenAsItSays) {
  spdlog::set_level(spdlog::level::off);
  TimeToEnd count;
  for (const unsigned seed : {31u, 32u}) count_cell(development_population(), seed, 3, 10, count);
  EXPECT_GT(count.rereads_per_row / count.runs, 0.03);
  for (const auto& at : count.at) {
    ASSERT_EQ(at.asked, 20);
    // 80 % of 20 is 16; fewer than 11 has a probability of 0.3 % (binomial).
    EXPECT_GE(at.inside, 11) << at.early << " ended early, " << at.late << " late";
    EXPECT_LT(at.width_share / at.asked, 1.5) << "a band that says nothing";
  }
}

}  // namespace
}  // namespace driftwise::tests
