// A model beside another at its promotion: their figures are compared where they are of one
// dataset.

#include <gtest/gtest.h>

#include "server/calibration/report/accuracy.h"
#include "server/formats/formula/formula.h"
#include "tests/unit/calibration/campaign.h"

namespace driftwise::calibration {
namespace {

Model fitted(const char* formula, RunId run, unsigned seed) {
  FitOptions options;
  options.lineage.runs = {run};
  auto model = formats::fit_formula(make_campaign({.seed = seed}), formula, options);
  EXPECT_TRUE(model) << model.error().message;
  return std::move(*model);
}

TEST(Heading, ComparesModelsOfTheSameRowsAlone) {
  const auto before = fitted("q1 ~ x + T", RunId{4}, 1);
  const auto better = heading_of(fitted("q1 ~ x + x^2 + T", RunId{4}, 1), before);
  ASSERT_FALSE(better.empty());
  ASSERT_TRUE(better[0].before);
  EXPECT_GT(better[0].before->a90, better[0].figures.a90);
  const auto of_another_run = heading_of(fitted("q1 ~ x + x^2 + T", RunId{2}, 2), before);
  ASSERT_FALSE(of_another_run.empty());
  EXPECT_FALSE(of_another_run[0].before) << "another run has other rows";
}

}  // namespace
}  // namespace driftwise::calibration
