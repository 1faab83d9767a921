// The words beside "adequate" where slow noise has taken a drift.

#include "server/diagnosis/report/taken_by_time.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "server/formats/diagnosis/diagnosis_json.h"
#include "tests/unit/diagnosis/diagnosed.h"

namespace driftwise::diagnosis {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

// The zero wanders: noise of half an hour, within it what a tester took for a drift. No
// thermometer.
Dataset wandering(double slow_um, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::vector<double> x, ex;
  double slow = 0;
  Dataset data;
  for (std::size_t row = 0; row < 200; ++row) {
    slow += slow_um * normal(random);
    x.push_back(40.0 * static_cast<double>(row % 42 < 21 ? row % 42 : 41 - row % 42));
    ex.push_back(slow + 0.1 * normal(random));
    data.time_s.push_back(12.0 * static_cast<double>(row));
  }
  data.rows = data.time_s.size();
  data.columns = {{{"x", "mm"}, x}, {{"ex", "um"}, ex}};
  return data;
}

TEST(WhatGoesWithTheTime, IsSaidBesideAnAdequateVerdict) {
  Diagnosis diagnosis;
  diagnosis.outputs.push_back({.output = "ex", .unit = "nm"});
  auto& output = diagnosis.outputs.front();
  output.a90_calibration_after = 4950;
  output.noise_white_sd = 320;
  output.explained_by = {{"time", 0.981}, {"t02", 0.94}};
  EXPECT_THAT(taken_by_time(diagnosis), Contains(HasSubstr("98 % of what is left of ex goes")));
  output.explained_by = {{"t02", 0.94}, {"time", 0.6}};
  EXPECT_THAT(taken_by_time(diagnosis), IsEmpty());
  output.explained_by = {{"time", 0.981}};
  output.noise_white_sd = 2000;
  EXPECT_THAT(taken_by_time(diagnosis), IsEmpty());
}

TEST(WhatGoesWithTheTime, IsPrintedUnderTheVerdict) {
  int adequate = 0;
  for (const std::uint64_t seed : {3, 4, 8}) {
    const auto found = diagnosed(wandering(0.05, seed), "ex ~ x");
    if (found.verdict != Verdict::adequate || taken_by_time(found).empty()) continue;
    ++adequate;
    EXPECT_THAT(formats::diagnosis_page(found), HasSubstr("slow noise has most of what is left"));
    EXPECT_THAT(found.warnings, Contains(HasSubstr("goes smoothly with the time")));
  }
  EXPECT_EQ(adequate, 2);
  EXPECT_THAT(formats::diagnosis_page(diagnosed(wandering(0, 5), "ex ~ x")),
              Not(HasSubstr("slow noise")));
}

}  // namespace
}  // namespace driftwise::diagnosis
