// Noise that goes on from row to row, as a first-order process: what is reported of a size, and
// rows that are wrong in it. Judges: the size that was put in, and the same rows without the wrong
// ones.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "tests/unit/diagnosis/diagnosed.h"

namespace driftwise::diagnosis {
namespace slow_noise_test {
namespace {

constexpr std::size_t kRows = 300;
constexpr double kNoise_nm = 10;

// An axis of 100 mm that gives way under four loads. The noise of a row is `memory` times that of
// the row before and something new; kNoise_nm in all. A second part is white.
struct Axis {
  double memory = 0, compliance_nm_per_n = 0, white_nm = 0;

  Dataset measured(unsigned seed) const {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    Dataset data;
    data.rows = kRows;
    data.columns = {
        {{"q1", "mm"}, {}}, {{"x", "mm"}, {}}, {{"force", "N"}, {}}, {{"t01", "degC"}, {}}};
    double noise_nm = kNoise_nm * normal(random);
    for (std::size_t i = 0; i < kRows; ++i) {
      if (i > 0)
        noise_nm = memory * noise_nm + kNoise_nm * std::sqrt(1 - memory * memory) * normal(random);
      const double x = 100.0 / 14 * static_cast<double>(random() % 15);
      const double force_n = 2.0 * static_cast<double>(random() % 4);
      const double t_degc =
          20 + 0.3 * std::sin(static_cast<double>(i) / 20) + 0.001 * normal(random);
      const double nm = noise_nm + white_nm * normal(random) + compliance_nm_per_n * force_n +
                        100 * (t_degc - 20);
      data.time_s.push_back(60.0 * static_cast<double>(i));
      data.columns[0].values.push_back(1.0001 * x + 1e-7 * x * x + 1e-6 * nm);
      data.columns[1].values.push_back(x);
      data.columns[2].values.push_back(force_n);
      data.columns[3].values.push_back(t_degc);
    }
    return data;
  }
};

Dataset without_rows(Dataset data, const std::vector<std::size_t>& rows) {
  for (auto row = rows.rbegin(); row != rows.rend(); ++row) {
    const auto at = static_cast<std::ptrdiff_t>(*row);
    data.time_s.erase(data.time_s.begin() + at);
    for (auto& column : data.columns) column.values.erase(column.values.begin() + at);
    --data.rows;
  }
  return data;
}

Diagnosis of_axis(const Dataset& data) { return diagnosed(data, "q1 ~ x + x^2 + T"); }

// Whitened rows are in units of the white part, and it is 0.3 nm of these 10: a prior that is
// weighed by all of them holds half of the size back.
TEST(SizeInSlowNoise, IsTheSizeThatIsThere) {
  int covered = 0, sets = 0;
  double of_truth = 0;
  for (const double memory : {0.5, 0.8, 0.95})
    for (int k = 0; k < 3; ++k) {
      const auto seed = static_cast<unsigned>(++sets);
      // As strong beside what is new in a row, whatever the memory.
      const double truth = 4.0 * std::sqrt((1 - memory) / (1 + memory));
      const auto found = of_axis(Axis{memory, truth}.measured(seed));
      ASSERT_EQ(found.findings.size(), 1U) << memory << ", seed " << seed;
      ASSERT_EQ(found.findings[0].cause, "force_compliance") << memory << ", seed " << seed;
      const auto& size = found.findings[0].parameters.front();
      ASSERT_TRUE(size.ci90);
      covered += size.ci90->low < truth && truth < size.ci90->high;
      of_truth += size.value / truth;
    }
  EXPECT_GE(covered, sets - 2) << "of " << sets << ": two are outside of 90 % by chance";
  EXPECT_NEAR(of_truth / sets, 1, 0.1);
}

// A row's error is no observation that the noise before and after it is zero.
TEST(WrongRowsInSlowNoise, LeaveTheAnswerOfTheFileWithoutThem) {
  const std::vector<std::size_t> wrong = {25, 75, 125, 175, 225, 275};
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const Dataset less = Axis{0.95, 0, 2}.measured(seed);
    Dataset with = less;
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> error_nm(60, 75);
    for (std::size_t k = 0; k < wrong.size(); ++k)
      with.columns[0].values[wrong[k]] += (k % 2 == 0 ? -1e-6 : 1e-6) * error_nm(random);
    auto of_less = of_axis(without_rows(less, wrong));
    auto of_with = of_axis(with);
    const auto outliers =
        std::ranges::find(of_with.findings, std::string("outliers"), &Finding::cause);
    ASSERT_NE(outliers, of_with.findings.end()) << seed;
    EXPECT_EQ(outliers->rows, wrong) << seed;
    of_with.findings.erase(outliers);
    EXPECT_EQ(names_found(of_with), names_found(of_less)) << seed;
    EXPECT_EQ(of_with.left_over.size(), of_less.left_over.size()) << seed;
    EXPECT_NEAR(of_with.outputs[0].noise_white_sd, of_less.outputs[0].noise_white_sd,
                0.1 * of_less.outputs[0].noise_white_sd)
        << seed;
  }
}

}  // namespace
}  // namespace slow_noise_test
}  // namespace driftwise::diagnosis
