#include "server/core/records/served_in_order.h"

#include <gmock/gmock.h>

#include <cstdint>

namespace driftwise {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

class ServedInOrderTest : public testing::Test {
 protected:
  ServedInOrder<std::int64_t> served;
};

TEST_F(ServedInOrderTest, ARollbackTakesTheLastPromotionBack) {
  served.promoted(1);
  served.promoted(2);
  served.promoted(1);
  EXPECT_EQ(served.before(), 2);
  served.rolled_back(2);
  EXPECT_THAT(served.ids(), ElementsAre(1, 2));
  served.rolled_back(1);
  EXPECT_FALSE(served.before());
  served.rolled_back(std::nullopt);
  EXPECT_THAT(served.ids(), IsEmpty());
}

TEST_F(ServedInOrderTest, ARepeatedPromotionIsInServiceOnce) {
  served.promoted(1);
  served.promoted(2);
  served.promoted(2);
  EXPECT_THAT(served.ids(), ElementsAre(1, 2));
  EXPECT_EQ(served.before(), 1);
}

// As earlier versions left them: promoted 1, 2, 2, and rolled back from 2 to 2.
TEST_F(ServedInOrderTest, ARecordedRollbackToTheSameOneTakesNothingBack) {
  for (const int id : {1, 2, 2}) served.promoted(id);
  served.rolled_back(2);
  EXPECT_EQ(served.before(), 1);
  served.rolled_back(1);
  EXPECT_THAT(served.ids(), ElementsAre(1));
}

TEST_F(ServedInOrderTest, TheRecordedRollbackSaysWhatServesThen) {
  served.rolled_back(3);
  EXPECT_THAT(served.ids(), ElementsAre(3));
}

}  // namespace
}  // namespace driftwise
