#pragma once
// An axis as a laboratory measures it: up and down over eleven places, a reading a minute, a servo
// that comes to rest within 30 nm of its place and a pose that follows it, one thermometer.

#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "tests/unit/diagnosis/diagnosed.h"

namespace driftwise::diagnosis {

struct EverydayAxis {
  static constexpr std::size_t kRows = 500;
  std::vector<double> time_s, q_mm, x_mm, t01_degC, ry_arcsec;  // ry: none unless it is filled

  explicit EverydayAxis(unsigned seed) {
    constexpr double kNoise_mm = 5e-6, kServo_mm = 30e-6, kStep_mm = 0.25;
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    for (std::size_t i = 0; i < kRows; ++i) {
      const std::size_t k = i % 22;
      time_s.push_back(60.0 * static_cast<double>(i + 1));
      q_mm.push_back(kStep_mm * static_cast<double>(k < 11 ? k : 21 - k) +
                     kServo_mm * normal(random));
      t01_degC.push_back(20 + 0.5 * std::sin(2 * std::numbers::pi * time_s[i] / 86400) +
                         1e-3 * normal(random));
      x_mm.push_back(q_mm[i] + 3e-5 * q_mm[i] * q_mm[i] + 60e-6 * (t01_degC[i] - 20) +
                     kNoise_mm * normal(random));
    }
  }

  Dataset dataset() const {
    Dataset data;
    data.rows = kRows;
    data.time_s = time_s;
    data.columns = {{{"q1", "mm"}, q_mm}, {{"x", "mm"}, x_mm}, {{"t01", "degC"}, t01_degC}};
    if (!ry_arcsec.empty()) data.columns.push_back({{"ry", "arcsec"}, ry_arcsec});
    return data;
  }

  Diagnosis diagnosed() const { return diagnosis::diagnosed(dataset(), "q1 ~ x + x^2 + T"); }
};

}  // namespace driftwise::diagnosis
