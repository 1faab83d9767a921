#include "server/diagnosis/answer/discrepancy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace driftwise::diagnosis {
namespace {

using effects::Power;
using effects::Term;

calibration::Model scale_only() {
  calibration::Model model;
  calibration::OutputModel out;
  out.channel = {"q1", "mm"};
  out.terms = {Term{{Power{"x", 1}}}};
  out.coefficients = Eigen::VectorXd::Constant(1, 1.001);
  model.outputs = {out};
  return model;
}

// q = 1.001 x + drift_mm_per_k * (t07 - 21) + noise
Dataset drifting(double drift_mm_per_k, double noise_mm, std::size_t rows = 400) {
  Dataset data;
  data.rows = rows;
  DatasetColumn q{{"q1", "mm"}, {}}, x{{"x", "mm"}, {}}, t{{"t07", "degC"}, {}};
  std::mt19937 random(11);
  std::normal_distribution<double> noise(0, noise_mm);
  for (std::size_t i = 0; i < rows; ++i) {
    data.time_s.push_back(14.3 * static_cast<double>(i));
    x.values.push_back(-4.0 + 0.5 * static_cast<double>(i % 17));
    t.values.push_back(21 + 0.5 * std::sin(static_cast<double>(i) * 0.05));
    q.values.push_back(1.001 * x.values[i] + drift_mm_per_k * (t.values[i] - 21) + noise(random));
  }
  data.columns = {q, x, t};
  return data;
}

TEST(Discrepancy, GoesWithTheTemperatureThatTheModelLacks) {
  const auto found = discrepancy(scale_only(), drifting(4e-4, 5e-6));
  ASSERT_TRUE(found) << found.error().message;
  const auto& q1 = found->front();
  EXPECT_EQ(q1.unit, "nm");
  EXPECT_NEAR(q1.u90, 1.645 * 200 / std::sqrt(2.0), 10);  // amplitude 200 nm of a sine
  EXPECT_EQ(q1.explained_by.front().variable, "t07");
  EXPECT_GT(q1.explained_by.front().share, 0.99);
  EXPECT_GT(q1.lag1_autocorrelation, 0.9);
}

TEST(Discrepancy, OfAPerfectModelIsTheNoise) {
  const auto found = discrepancy(scale_only(), drifting(0, 5e-6));
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->front().u90, 1.645 * 5, 0.7);  // 400 rows: the sd is known to 3.5 %
  EXPECT_LT(found->front().explained_by.front().share, 0.05);
}

TEST(Discrepancy, CountsMissingValuesOut) {
  auto data = drifting(0, 5e-6);
  data.columns[1].values[3] = kMissing;
  const auto found = discrepancy(scale_only(), data);
  ASSERT_TRUE(found);
  EXPECT_TRUE(std::isnan(found->front().values[3]));
  EXPECT_TRUE(std::isfinite(found->front().u90));
}

TEST(Discrepancy, NamesTheChannelThatIsNotThere) {
  auto data = drifting(0, 5e-6);
  data.columns.erase(data.columns.begin());
  const auto found = discrepancy(scale_only(), data);
  ASSERT_FALSE(found);
  EXPECT_NE(found.error().message.find("q1_mm"), std::string::npos);
}

TEST(Discrepancy, RefusesTwoRows) {
  const auto found = discrepancy(scale_only(), drifting(0, 5e-6, 2));
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().reason, "TOO_FEW_ROWS");
}

}  // namespace
}  // namespace driftwise::diagnosis
