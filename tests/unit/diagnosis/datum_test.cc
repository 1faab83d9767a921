// A diagnosis over two datums has the second one where its zero lies, as a fit has it.

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/unit/diagnosis/diagnosed.h"

namespace driftwise::diagnosis {
namespace {

// q1 = x + 2e-3 x^2 with 5 nm of noise; from row 300 on the instruments were zeroed 8 um further
// along, the motor's scale was not: a constant alone leaves a slope of 32 nm per mm.
Dataset two_datums_on_a_curve() {
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal;
  Dataset data;
  for (const char* name : {"q1_mm", "x_mm"}) data.columns.push_back({*parse_channel(name), {}});
  for (int i = 0; i < 600; ++i) {
    const bool second = i >= 300;
    const double place = -3 + 0.25 * ((i * 7) % 25), p0 = second ? 8e-3 : 0;
    const auto q = [](double x) { return x + 2e-3 * x * x; };
    data.time_s.push_back(20.0 * i);
    data.datum.push_back(second ? 2 : 1);
    data.set.push_back(i % 5 == 2 ? PointSet::validation : PointSet::calibration);
    data.columns[0].values.push_back(q(place + p0) + 5e-6 * normal(random));
    data.columns[1].values.push_back(place);
    ++data.rows;
  }
  return data;
}

TEST(DiagnosisOverTwoDatums, FindsNothingInWhatIsOnlyAnotherZero) {
  DiagnoseOptions options;
  options.baseline = {
      "q1 ~ poly(x, 3)",
      {"q1"},
      {{{effects::Power{"x", 1}}}, {{effects::Power{"x", 2}}}, {{effects::Power{"x", 3}}}},
      true};
  const auto found = diagnose(two_datums_on_a_curve(), options);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->verdict, Verdict::adequate);
  for (const auto& finding : found->findings) ADD_FAILURE() << finding.sentence;
  EXPECT_LT(found->outputs.front().a90_calibration_before, 10) << "nm; noise: 8.2";
}

// Places of a computed plan, every one once in a datum, 6 um apart; the second datum was zeroed
// 80 nm further along. The noise is the motor's: a wave of 125 nm over the motor's reading would
// spell it out, were the plan not known for exact in either datum.
Dataset two_datums_of_exact_places() {
  std::mt19937_64 random(12);
  std::normal_distribution<double> normal;
  Dataset data;
  for (const char* name : {"q1_mm", "x_mm"}) data.columns.push_back({*parse_channel(name), {}});
  for (int i = 0; i < 600; ++i) {
    const bool second = i >= 300;
    const double place = -3 + 0.006 * ((i * 618) % 1000);
    data.time_s.push_back(60.0 * i + (second ? 86400 : 0));
    data.datum.push_back(second ? 2 : 1);
    data.columns[0].values.push_back(place + (second ? 8e-5 : 0) + 5e-6 * normal(random));
    data.columns[1].values.push_back(place);
    ++data.rows;
  }
  return data;
}

TEST(DiagnosisOverTwoDatums, DoesNotReadTheNoiseOutOfExactPlaces) {
  DiagnoseOptions options;
  options.baseline = {"q1 ~ x", {"q1"}, {{{effects::Power{"x", 1}}}}, true};
  const auto found = diagnose(two_datums_of_exact_places(), options);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->verdict, Verdict::adequate);
  for (const auto& finding : found->findings) ADD_FAILURE() << finding.sentence;
  EXPECT_GT(found->outputs.front().a90_calibration_after, 7) << "nm; noise: 8.2";
}

// A run that was zeroed afresh and only judges: its zero, 5 um away, is no error of the simulation.
// `known`: validation rows of the first datum are left.
Dataset validated_in_another_datum(bool known) {
  std::mt19937_64 random(13);
  std::normal_distribution<double> normal;
  Dataset data;
  for (const char* name : {"q1_mm", "x_mm"}) data.columns.push_back({*parse_channel(name), {}});
  for (int i = 0; i < 400; ++i) {
    const bool second = i >= 280;
    const double place = -3 + 0.25 * ((i * 7) % 25);
    data.time_s.push_back(20.0 * i);
    data.datum.push_back(second ? 2 : 1);
    data.set.push_back(second || (known && i % 7 == 3) ? PointSet::validation
                                                       : PointSet::calibration);
    data.columns[0].values.push_back(place + (second ? -5e-3 : 0) + 8e-6 * normal(random));
    data.columns[1].values.push_back(place);
    ++data.rows;
  }
  return data;
}

TEST(DiagnosisOverTwoDatums, JudgesByNoRowOfADatumThatNoRowTeaches) {
  for (const bool known : {true, false}) {
    const auto found = diagnosed(validated_in_another_datum(known), "q1 ~ x");
    EXPECT_EQ(found.verdict, Verdict::adequate) << known;
    EXPECT_EQ(found.rows_held_out, known ? 40U : 280U);
    EXPECT_EQ(found.judged_on, known ? JudgedRows::validation : JudgedRows::blocks);
    // 1.645 x 8 nm; of 40 rows it is known to a fifth.
    EXPECT_NEAR(found.outputs.front().a90_validation_before.value_or(0), 13.2, 4) << known;
    EXPECT_TRUE(std::ranges::count(found.warnings,
                                   "120 validation rows left out: their datum has no calibration "
                                   "rows to take its constant from"))
        << known;
    EXPECT_EQ(names_found(found), std::vector<std::string>{});
  }
}

}  // namespace
}  // namespace driftwise::diagnosis
