#include "server/core/data/unusable_values.h"

#include <gtest/gtest.h>

#include <cmath>

namespace driftwise {
namespace {

TEST(UnusableValues, AreTakenAsMissingAndNamed) {
  Dataset data;
  data.rows = 4;
  data.columns = {{{"x", "mm"}, {0, INFINITY, 2, 3}}, {{"t01", "degC"}, {20, 20, 1e308, kMissing}}};
  const auto usable = without_unusable(data);
  ASSERT_TRUE(usable);
  EXPECT_TRUE(is_missing(usable->data.columns[0].values[1]));
  EXPECT_TRUE(is_missing(usable->data.columns[1].values[2]));
  EXPECT_EQ(usable->data.columns[0].values[3], 3);
  EXPECT_EQ(usable->sentence,
            "2 rows hold values that no instrument can have measured, taken as missing (row 2: "
            "x_mm inf; row 3: t01_degC 1e+308)");
}

// What a SCPI instrument answers for an overflow and for a value that it does not have.
TEST(UnusableValues, OverflowOfAScpiInstrumentIsOne) {
  Dataset data;
  data.rows = 4;
  data.columns = {{{"t01", "degC"}, {20, 9.9e37, -9.9e37, 9.91e37}}};
  const auto usable = without_unusable(data);
  ASSERT_TRUE(usable);
  EXPECT_EQ(usable->data.columns[0].values[0], 20);
  for (std::size_t row = 1; row < 4; ++row)
    EXPECT_TRUE(is_missing(usable->data.columns[0].values[row])) << row;
}

TEST(UnusableValues, AMissingValueIsNone) {
  Dataset data;
  data.rows = 2;
  data.columns = {{{"x", "mm"}, {kMissing, 1e29}}};
  EXPECT_FALSE(without_unusable(data));
}

}  // namespace
}  // namespace driftwise
