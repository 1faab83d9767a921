#include "server/application/pace.h"

#include <gtest/gtest.h>

namespace driftwise::application {
namespace {

TEST(Pace, GuessesBeforeTheFirstPoint) {
  Pace pace(14);
  EXPECT_EQ(pace.estimated_end(CellTime{0}, 10).utc_ns, 140'000'000'000);
}

TEST(Pace, FollowsTheLastPoints) {
  Pace pace(14);
  for (int i = 0; i < 1000; ++i) pace.add(i < 900 ? 100.0 : 10.0);
  EXPECT_DOUBLE_EQ(pace.point_s(), 10.0);
  EXPECT_EQ(pace.estimated_end(CellTime{5}, 3).utc_ns, 30'000'000'005);
}

}  // namespace
}  // namespace driftwise::application
