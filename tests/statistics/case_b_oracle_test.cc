// Case B on ten simulated machines: the published four models, and what is left between the best
// one and an oracle that knows the robot. Prints the table of docs/uncertainty.md. The project's
// aim is 1.15 for the last column; what is reached stands there too.

#include "tests/statistics/case_b_oracle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

namespace driftwise::statistics {
namespace {

double median_of(std::vector<double> values) {
  std::ranges::sort(values);
  return (values[(values.size() - 1) / 2] + values[values.size() / 2]) / 2;
}

TEST(CaseB, CrossTermsTakeTheFullModelCloseToAnOracleThatKnowsTheRobot) {
  constexpr int kSeeds = 10;
  std::vector<CaseBFigures> all;
  std::printf("U90 on the validation grid inside the forces, nm: q1 q2 q3\nseed");
  for (const auto& model : case_b_models()) std::printf("  %17s", model.name);
  std::printf("  %17s  cross/oracle\n", "oracle");
  std::vector<double> ratios;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    all.push_back(case_b_figures(seed));
    const auto& figures = all.back();
    std::printf("%4d", static_cast<int>(seed));
    for (const auto& u90 : figures.models)
      std::printf("  %5.0f %5.0f %5.0f", u90[0], u90[1], u90[2]);
    std::printf("  %5.1f %5.1f %5.1f ", figures.oracle[0], figures.oracle[1], figures.oracle[2]);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      ratios.push_back(figures.models.back()[axis] / figures.oracle[axis]);
      std::printf(" %.3f", ratios.back());
    }
    std::printf("\n");
  }
  std::printf("med.");
  const auto median = [&](auto figure_of) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::vector<double> values;
      for (const auto& figures : all) values.push_back(figure_of(figures)[axis]);
      std::printf(" %5.1f", median_of(values));
    }
    std::printf(" ");
  };
  for (std::size_t m = 0; m < case_b_models().size(); ++m)
    median([m](const CaseBFigures& figures) { return figures.models[m]; });
  median([](const CaseBFigures& figures) { return figures.oracle; });
  std::printf(" %.3f\n", median_of(ratios));
  EXPECT_LT(median_of(ratios), 1.25);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::vector<double> gain;  // of the products of force and temperature with the pose
    for (const auto& figures : all)
      gain.push_back(figures.models[4][axis] / figures.models[3][axis]);
    EXPECT_LT(median_of(gain), 0.9) << axis;
  }
}

}  // namespace
}  // namespace driftwise::statistics
