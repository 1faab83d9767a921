// Noise with heavy tails: half of the variance of Student's law with three degrees of freedom is in
// a few rows that say little, and a normal law gives them all the weight.

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/unit/diagnosis/diagnosed.h"

namespace driftwise::diagnosis {
namespace heavy_tails_test {
namespace {

// Up and down over eleven places of a rail, a reading every eight seconds, that jumps once.
Dataset rail_that_jumps(std::uint64_t seed, double jump_um) {
  constexpr std::size_t kRows = 242, kJump = 97;
  std::mt19937_64 random(seed);
  std::student_t_distribution<double> heavy(3);
  Dataset data;
  std::vector<double> x, ex;
  for (std::size_t row = 0; row < kRows; ++row) {
    const std::size_t k = row % 22;
    x.push_back(50.0 * static_cast<double>(k < 11 ? k : 21 - k));
    ex.push_back(0.01 * x.back() + 0.3 * heavy(random) + (row >= kJump ? jump_um : 0));
    data.time_s.push_back(8.0 * static_cast<double>(row));
  }
  data.rows = kRows;
  data.columns = {{{"x", "mm"}, x}, {{"ex", "um"}, ex}};
  return data;
}

// 0.6 um: chi squared of 77 by the variance of the noise, of 155 by its law.
TEST(AJumpInHeavyTails, IsNamedByWhatEachRowSaysUnderThatLaw) {
  int named = 0, allowed_for = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto found = diagnosed(rail_that_jumps(seed, 0.6), "ex ~ x");
    named += names_found(found) == std::vector<std::string>{"step_change x"} ? 1 : 0;
    const bool by_the_law = std::ranges::any_of(found.warnings, [](const std::string& warning) {
      return warning.find("heavy tails") != std::string::npos;
    });
    allowed_for += by_the_law ? 1 : 0;
  }
  EXPECT_GE(named, 7) << "2 with a normal law, 9 with Student's";
  EXPECT_GE(allowed_for, 10);
}

TEST(HeavyTails, WithoutAJumpHaveNoName) {
  int named = 0;
  for (std::uint64_t seed = 101; seed <= 140; ++seed)
    named += diagnosed(rail_that_jumps(seed, 0), "ex ~ x").findings.empty() ? 0 : 1;
  EXPECT_LE(named, 1);
}

}  // namespace
}  // namespace heavy_tails_test
}  // namespace driftwise::diagnosis
