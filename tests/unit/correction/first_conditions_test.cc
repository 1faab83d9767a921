// A scale that goes with the air is 0 where the measurement was set up.

#include "server/correction/first_conditions.h"

#include <gtest/gtest.h>

#include <limits>

#include "server/correction/data_amendment.h"

namespace driftwise::correction {
namespace {

using effects::Call;
using effects::Power;
using effects::Term;

Term product_of(const std::string& a, const std::string& b) { return {{Power{a, 1}, Power{b, 1}}}; }

Dataset falling_pressure() {
  Dataset data;
  data.columns = {{{"x", "mm"}, {0, 2, -1, 2}},
                  {{"pressure", "hPa"}, {965, 965, 962, 959}},
                  {{"rx", "arcsec"}, {0, 3, 1, -2}}};
  data.time_s = {0, 60, 120, 180};
  data.rows = 4;
  return data;
}

TEST(FirstConditions, TakeNothingOffWhereTheMeasurementBegan) {
  Dataset data = falling_pressure();
  LengthShift shift;
  shift.axis = "x";
  shift.terms = {product_of("x", "pressure")};
  shift.mm = {-2e-7};
  ASSERT_TRUE(count_from_first(data, shift.terms, shift.mm));
  const std::vector<RowOrigin> origins = {{{1}, 0}, {{1}, 1}, {{1}, 2}, {{1}, 3}};
  DataAmendment amendment;
  amendment.shifts = {shift};
  ASSERT_TRUE(amend(amendment, origins, {}, data));
  const auto x = data.values_of("x");
  EXPECT_DOUBLE_EQ(x[1], 2) << "the pressure is still what it was";
  // 0.2 ppm/hPa over the 3 and 6 hPa that it has fallen, of -1 and 2 mm.
  EXPECT_NEAR(x[2], -1 + 2e-7 * 3 * 1, 1e-15);
  EXPECT_NEAR(x[3], 2 - 2e-7 * 6 * 2, 1e-15);
}

TEST(FirstConditions, LeaveTermsOfThePoseOrOfTheAirAlone) {
  std::vector<Term> terms = {product_of("x", "rx"), {{Power{"pressure", 1}}}};
  std::vector<double> mm = {1e-6, 2e-6};
  ASSERT_TRUE(count_from_first(falling_pressure(), terms, mm));
  EXPECT_EQ(terms.size(), 2U);
}

TEST(FirstConditions, LeaveTheClockAlone) {
  std::vector<Term> terms = {{{Power{"x", 1}, Call{"drift", {}, {}}}}};
  std::vector<double> mm = {1e-9};
  ASSERT_TRUE(count_from_first(falling_pressure(), terms, mm));
  EXPECT_EQ(terms.size(), 1U);
}

TEST(FirstConditions, StartWhereTheChannelFirstGaveAValue) {
  Dataset data = falling_pressure();
  data.columns[1].values[0] = std::numeric_limits<double>::quiet_NaN();
  data.columns[1].values[1] = 964;
  std::vector<Term> terms = {product_of("x", "pressure")};
  std::vector<double> mm = {1e-7};
  ASSERT_TRUE(count_from_first(data, terms, mm));
  ASSERT_EQ(terms.size(), 2U);
  EXPECT_EQ(terms[1], (Term{{Power{"x", 1}}}));
  EXPECT_DOUBLE_EQ(mm[1], -964e-7);
}

}  // namespace
}  // namespace driftwise::correction
