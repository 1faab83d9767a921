// The search smooths thermometers, a model that serves has the readings. Where a coefficient is so
// large that the readings' noise matters, the diagnosis says what either is worth.

#include "server/diagnosis/report/as_read.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <regex>

#include "server/diagnosis/rows/problem.h"
#include "server/formats/formula/formula.h"

namespace driftwise::diagnosis {
namespace {

constexpr std::size_t kReadRows = 400;
constexpr double kReadStep_s = 60, kReadNoise_k = 2e-3, kLengthNoise_nm = 5;

// q1 follows x and the part that t01 is on, whose temperature t01 reads to 2 mK.
Dataset read_with_noise(double nm_per_k) {
  std::mt19937_64 random(23);
  std::normal_distribution<double> normal;
  Dataset data;
  data.rows = kReadRows;
  DatasetColumn q{{"q1", "mm"}, {}}, x{{"x", "mm"}, {}}, t01{{"t01", "degC"}, {}};
  for (std::size_t row = 0; row < kReadRows; ++row) {
    const double t_s = kReadStep_s * static_cast<double>(row);
    const double part_k = 0.4 * std::sin(t_s / 5000) + 0.3 * std::sin(t_s / 1700 + 1);
    const double at_mm = -3 + 6 * std::fmod(0.618 * static_cast<double>(row), 1.0);
    x.values.push_back(at_mm);
    t01.values.push_back(20 + part_k + kReadNoise_k * normal(random));
    q.values.push_back(at_mm + 1e-6 * (nm_per_k * part_k + kLengthNoise_nm * normal(random)));
    data.time_s.push_back(t_s);
  }
  data.columns = {q, x, t01};
  return data;
}

std::vector<std::string> notes_of(double nm_per_k) {
  const Dataset data = read_with_noise(nm_per_k);
  const auto problem = lay_out(data, *formats::Formula::parse("q1 ~ x + t01")->expand(data), 4000);
  if (!problem) return {problem.error().message};
  return worse_as_read(*problem, data);
}

// 20 um/K times 2 mK is 40 nm: 66 nm of A90 as read, less than half of it after smoothing.
TEST(AsRead, SaysWhereTheReadingsNoiseIsWhatTheModelWillHave) {
  const auto notes = notes_of(20000);
  ASSERT_EQ(notes.size(), 1U);
  const std::regex figures(
      "q1: with the thermometers as they were read the baseline describes rows held out to "
      "([0-9.]+) nm \\(A90\\), with smoothed readings, as here, to ([0-9.]+) nm.*");
  std::smatch said;
  ASSERT_TRUE(std::regex_match(notes[0], said, figures)) << notes[0];
  // Of 400 normal readings the rms is known to 3.5 %.
  EXPECT_NEAR(std::stod(said[1]), 1.645 * std::hypot(20000 * kReadNoise_k, kLengthNoise_nm), 8);
  EXPECT_LT(std::stod(said[2]), 0.5 * std::stod(said[1]));
}

TEST(AsRead, IsSilentWhereTheReadingsAreQuietEnough) { EXPECT_TRUE(notes_of(300).empty()); }

}  // namespace
}  // namespace driftwise::diagnosis
