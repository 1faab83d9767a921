// A thousand stops in a row are obeyed each, and are two lines of the record: the first at once,
// and one with the count.

#include <gmock/gmock.h>

#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

class Stops : public testing::Test {
 protected:
  Folder folder;
  SmallWorld world;
  CellInMemory cell{world, small_cell(folder / "cell.sqlite"), kSqlite};

  void stop(const std::string& name, int times) {
    for (int i = 0; i < times; ++i)
      ASSERT_TRUE(cell.await(cell->manual.stop_all({name, "ipv4:127.0.0.1:5020", {}})));
  }
};

TEST_F(Stops, AThousandInARowAreOneEventWithACount) {
  stop("ada", 1);
  EXPECT_THAT(cell.events_named("stop"), testing::ElementsAre("ada stopped everything"))
      << "the first one is on record at once";
  stop("ada", 600);
  stop("bob", 399);
  cell.pass(15);
  EXPECT_EQ(cell.events_named("stop").size(), 1U);
  EXPECT_THAT(cell.events_named("stop.repeated"),
              testing::ElementsAre("999 further stops, 1000 in a row, by ada, bob"));
}

TEST_F(Stops, OneAfterTheOtherAreOneEventEach) {
  stop("ada", 1);
  cell.pass(20);
  stop("bob", 1);
  cell.pass(20);
  EXPECT_EQ(cell.events_named("stop").size(), 2U);
  EXPECT_TRUE(cell.events_named("stop.repeated").empty());
}

TEST_F(Stops, WhatWasCountedIsToldBeforeTheDaemonEnds) {
  stop("ada", 3);
  cell.shut_down();
  const CellInMemory after(world, small_cell(folder / "cell.sqlite"), kSqlite,
                           kWorldBegin + std::chrono::hours(1));
  EXPECT_THAT(const_cast<CellInMemory&>(after).events_named("stop.repeated"),
              testing::ElementsAre("2 further stops, 3 in a row, by ada"));
}

}  // namespace
}  // namespace driftwise::tests
