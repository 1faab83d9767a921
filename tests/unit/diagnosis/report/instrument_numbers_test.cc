// An instrument's error as the instrument has it, whatever the motor beside it: x reads more and
// more than it should, and the motor has that in its own unit through its lead.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "tests/unit/diagnosis/diagnosed.h"

namespace driftwise::diagnosis {
namespace {

constexpr std::size_t kReadings = 400;

// motor: reading at a true place in mm.
template <class Motor>
Dataset drifting(const Motor& motor, const std::string& unit, double nm_per_h) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  Dataset data;
  data.rows = kReadings;
  data.columns = {{{"q1", unit}, {}}, {{"x", "mm"}, {}}};
  for (std::size_t row = 0; row < kReadings; ++row) {
    const double hours = static_cast<double>(row) / 60,
                 place_mm = static_cast<double>(random() % 41) - 20;
    data.time_s.push_back(3600 * hours);
    data.columns[0].values.push_back(motor(place_mm));
    data.columns[1].values.push_back(place_mm + 1e-6 * (nm_per_h * hours + 5 * normal(random)));
  }
  return data;
}

double number(const Diagnosis& found, const std::string& name) {
  for (const auto& finding : found.findings)
    for (const auto& parameter : finding.parameters)
      if (parameter.name == name) return parameter.value;
  ADD_FAILURE() << "no " << name << " in "
                << (found.findings.empty() ? "no finding" : found.findings[0].sentence);
  return 0;
}

TEST(AnInstrumentsError, HasTheSizeAndSignOfItsReading) {
  const auto direct = [](double mm) { return mm; };
  const auto lead = [](double mm) { return 5 - 2 * mm; };
  const auto screw = [](double mm) { return 90 * mm; };  // 4 mm a turn
  for (const double nm_per_h : {60.0, -60.0}) {
    EXPECT_NEAR(number(diagnosed(drifting(direct, "mm", nm_per_h), "q1 ~ x"), "nm_per_h"), nm_per_h,
                3);
    EXPECT_NEAR(number(diagnosed(drifting(lead, "mm", nm_per_h), "q1 ~ x"), "nm_per_h"), nm_per_h,
                3);
    EXPECT_NEAR(number(diagnosed(drifting(screw, "deg", nm_per_h), "q1 ~ x"), "nm_per_h"), nm_per_h,
                3);
    EXPECT_NEAR(number(diagnosed(drifting(direct, "mm", nm_per_h), "x ~ q1"), "nm_per_h"), nm_per_h,
                3);
  }
}

TEST(AnInstrumentsError, IsSaidInItsOwnUnit) {
  const auto found = diagnosed(drifting([](double mm) { return 90 * mm; }, "deg", 100), "q1 ~ x");
  ASSERT_EQ(found.findings.size(), 1U);
  EXPECT_THAT(found.findings[0].sentence, ::testing::HasSubstr("nm/h"));
  EXPECT_THAT(found.findings[0].sentence, ::testing::Not(::testing::HasSubstr("arcsec/h")));
}

}  // namespace
}  // namespace driftwise::diagnosis
