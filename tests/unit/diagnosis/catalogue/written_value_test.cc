// Numbers in the terms of a finding, as they are copied into a formula.

#include <gmock/gmock.h>

#include "server/diagnosis/catalogue/parameter.h"

namespace driftwise::diagnosis {
namespace {

Cause searched(ParameterScale scale, std::initializer_list<double> grid) {
  Cause cause{.id = "cause", .subject = "q1", .where = "robot", .scale = scale};
  for (const double value : grid) cause.cells.push_back({value, {}});
  return cause;
}

TEST(AValueInATerm, HasSixDigitsWhereTheGridIsCoarse) {
  const auto play = searched(ParameterScale::logarithmic, {100, 200, 400, 800});
  EXPECT_EQ(as_written(play, 313.43600293706527), 313.436);
  EXPECT_EQ(as_written(play, 400), 400);
}

// A rounded period must not lose its phase over thousands of cycles.
TEST(AValueInATerm, KeepsTheDigitsThatTheSearchOfAPeriodTellsApart) {
  const auto wave = searched(ParameterScale::inverse, {316.40, 316.41, 316.42, 316.43});
  EXPECT_EQ(as_written(wave, 316.412345678912), 316.412346);
}

TEST(AValueInATerm, IsTheInstantItselfOfAStep) {
  const auto step = searched(ParameterScale::instant, {1000, 2000, 3000});
  EXPECT_EQ(as_written(step, 1234.5678912345), 1234.5678912345);
}

}  // namespace
}  // namespace driftwise::diagnosis
