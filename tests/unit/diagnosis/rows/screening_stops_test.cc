// The look at the thermometers: what it costs, and that it ends when it is told to.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "server/diagnosis/rows/screen.h"
#include "tests/unit/diagnosis/diagnosed.h"

namespace driftwise::diagnosis {
namespace screening_stops_test {
namespace {

// Six thermometers of which each changes by fifteen of its usual changes now and then, on its own;
// the robot follows the first one.
Dataset restless(unsigned seed) {
  constexpr std::size_t kSensors = 6;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Dataset data;
  data.rows = 300;
  data.columns = {{{"q1", "mm"}, {}}, {{"x", "mm"}, {}}};
  for (std::size_t s = 1; s <= kSensors; ++s)
    data.columns.push_back({{"t0" + std::to_string(s), "degC"}, {}});
  std::vector<double> part(kSensors, 20);
  for (std::size_t row = 0; row < data.rows; ++row) {
    data.time_s.push_back(30.0 * static_cast<double>(row));
    for (double& one : part) one += 0.01 * normal(random) * (random() % 20 == 0 ? 15 : 1);
    const double at = 0.5 * static_cast<double>(random() % 21);
    data.columns[0].values.push_back(at + 300e-6 * (part[0] - 20) + 5e-6 * normal(random));
    data.columns[1].values.push_back(at);
    for (std::size_t s = 0; s < kSensors; ++s)
      data.columns[s + 2].values.push_back(part[s] + 1e-3 * normal(random));
  }
  return data;
}

calibration::Candidates baseline() {
  calibration::Candidates result;
  result.outputs = {"q1"};
  result.terms = {{{effects::Power{"x", 1}}}, {{effects::Power{"t01", 1}}}};
  return result;
}

// Readings that no hypothesis changes are laid out once, whatever levels are asked for.
TEST(TheLookAtThermometers, LaysTheSameReadingsOutOnce) {
  const Dataset data = restless(1);
  int laid = 0;
  const auto likelihood = likelihood_of([&](const Dataset& given) {
    ++laid;
    auto problem = lay_out(given, baseline(), kMostSearched);
    return problem ? std::optional(*problem) : std::nullopt;
  });
  const double as_read = likelihood(data, {});
  for (std::size_t row = 20; row < 280; row += 20)
    EXPECT_NE(likelihood(data, {row, 0, true}), as_read);
  EXPECT_EQ(laid, 1);
  Dataset other = data;
  other.columns[2].values[7] += 1;
  EXPECT_NE(likelihood(other, {}), as_read);
  EXPECT_EQ(laid, 2);
}

TEST(TheLookAtThermometers, IsProgressAndEndsWhenItIsTold) {
  int calls = 0, after = 0;
  std::string last;
  DiagnoseOptions options;
  options.baseline = baseline();
  options.progress = [&](double, const std::string& step) {
    last = step;
    after += calls >= 4 ? 1 : 0;
    return ++calls < 4;
  };
  const auto found = diagnose(restless(2), options);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, ErrorCode::cancelled);
  EXPECT_EQ(last, "reading the rows") << "the fourth call is of the look, not after it";
  EXPECT_EQ(after, 0);
}

}  // namespace
}  // namespace screening_stops_test
}  // namespace driftwise::diagnosis
