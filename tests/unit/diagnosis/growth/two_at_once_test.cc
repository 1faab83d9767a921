// Effects that slow noise imitates: one alone in white noise, and two that hide each other.

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/diagnosis/everyday_axis.h"

namespace driftwise::diagnosis {
namespace {

constexpr double kNm = 1e-6;  // in mm

// A wave of 2 h and a second thermometer's part, each far above the noise of 5 nm: beside either,
// what the other leaves goes slowly up and down, and slow noise does as well.
Diagnosis of_a_wave_and_a_part(unsigned seed, double wave_nm, double part_nm_per_k) {
  EverydayAxis axis(300 + seed);
  std::mt19937_64 random(9000 + seed);
  std::normal_distribution<double> normal;
  std::vector<double> t02_degC;
  for (std::size_t row = 0; row < EverydayAxis::kRows; ++row) {
    const double turns = 2 * std::numbers::pi * axis.time_s[row];
    t02_degC.push_back(20 + 0.3 * std::sin(turns / 17000 + 1) +
                       0.15 * std::sin(turns / 6100 + seed) + 1e-3 * normal(random));
    axis.x_mm[row] +=
        kNm * (wave_nm * std::sin(turns / 7000 + seed) + part_nm_per_k * (t02_degC[row] - 20));
  }
  Dataset data = axis.dataset();
  data.columns.push_back({{"t02", "degC"}, std::move(t02_degC)});
  return diagnosed(data, "q1 ~ x + x^2 + t01");
}

TEST(TwoCauses, AreFoundWhereEitherHidesTheOther) {
  int both = 0;
  for (unsigned seed = 0; seed < 6; ++seed) {
    auto found = names_found(of_a_wave_and_a_part(seed, 6, 12));
    std::ranges::sort(found);
    both +=
        found == std::vector<std::string>{"periodic_disturbance x", "thermal_offset t02"} ? 1 : 0;
  }
  EXPECT_GE(both, 5);
}

// 20 nm in eight hours, of which the thermometer in the simulation can take a part.
TEST(ADriftInWhiteNoise, IsNotTakenForSlowNoise) {
  int named = 0;
  for (unsigned seed = 0; seed < 8; ++seed) {
    EverydayAxis axis(400 + seed);
    for (std::size_t row = 0; row < EverydayAxis::kRows; ++row)
      axis.x_mm[row] += 22 * kNm * axis.time_s[row] / axis.time_s.back();
    named +=
        names_found(axis.diagnosed()) == std::vector<std::string>{"instrument_drift x"} ? 1 : 0;
  }
  EXPECT_GE(named, 6);
}

}  // namespace
}  // namespace driftwise::diagnosis
