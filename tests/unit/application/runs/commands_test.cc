// What clients ask, refused or done.

#include <gmock/gmock.h>

#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

class Commands : public testing::Test {
 protected:
  Folder folder;
  SmallWorld world;
  CellInMemory cell{world, small_cell(folder / "cell.sqlite"), kSqlite};
  application::CreateRun request(const std::string& csv) {
    application::CreateRun r;
    r.name = "r";
    r.trajectory_name = "r.csv";
    r.trajectory_text = csv;
    return r;
  }
};

TEST_F(Commands, ARunNeedsTheLease) {
  auto r = request(lines_of(1, {1}, false));
  r.lease_token = "guess";
  EXPECT_EQ(cell.try_run(r).error().code, ErrorCode::permission_denied);
}

TEST_F(Commands, ASecondRunIsRefusedWhileOneIsUnderWay) {
  cell.begin_run(lines_of(1, {1}, false));
  const auto second = cell.try_run(request(lines_of(1, {1}, false)));
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().reason, "RUN_UNDER_WAY");
  EXPECT_EQ(cell.await(cell->manual.move_to(cell.ada, cell.lease(), {1})).error().reason,
            "RUN_UNDER_WAY");
  EXPECT_EQ(cell.await(cell->manual.home(cell.ada, cell.lease())).error().reason, "RUN_UNDER_WAY");
}

TEST_F(Commands, ASecondRunIsToldThatAPausedOneDoesNotEndByItself) {
  const auto run = cell.begin_run(lines_of(2, {1, 2, -1}, false));
  ASSERT_TRUE(cell.await(cell->runs.pause(cell.ada, run.id)));
  cell.until([&] { return cell.status().run->run.state == RunState::paused; });
  EXPECT_THAT(cell.try_run(request(lines_of(1, {1}, false))).error().message,
              testing::HasSubstr("is paused: abort it, or resume it and wait until it is over"));
}

TEST_F(Commands, TheSameRequestTwiceIsOneRun) {
  auto r = request(lines_of(1, {1}, false));
  r.request_id = "7d0f";
  const auto first = cell.try_run(r);
  const auto again = cell.try_run(r);
  ASSERT_TRUE(first && again);
  EXPECT_EQ(first->id, again->id);
  cell.finish_run();
  const auto later = cell.try_run(r);
  ASSERT_TRUE(later);
  EXPECT_EQ(later->id, first->id);
  EXPECT_EQ(later->state, RunState::done);
  EXPECT_EQ(cell.await(cell.runs(10, 0))->size(), 1u);
}

TEST_F(Commands, NothingMovesOutsideTheSoftLimits) {
  EXPECT_EQ(cell.try_run(request(lines_of(1, {5.1}, false))).error().reason, "SOFT_LIMIT");
  EXPECT_EQ(cell.await(cell->manual.move_to(cell.ada, cell.lease(), {-5.001})).error().reason,
            "SOFT_LIMIT");
  EXPECT_EQ(cell.await(cell->manual.move_to(cell.ada, cell.lease(), {1, 2})).error().reason,
            "AXIS_COUNT");
  EXPECT_EQ(cell.await(cell->manual.move_to(cell.ada, cell.lease(), {kMissing})).error().reason,
            "SOFT_LIMIT");
  EXPECT_EQ(world.moves, 0);
}

TEST_F(Commands, MovesByHandAndSaysWho) {
  ASSERT_TRUE(cell.await(cell->manual.home(cell.ada, cell.lease())));
  ASSERT_TRUE(cell.await(cell->manual.move_to(cell.ada, cell.lease(), {1.5})));
  EXPECT_NEAR(world.to_mm, 1.5, 1e-4);
  EXPECT_EQ(cell.events_named("axes.move").front(), "ada moves to 1.5 mm");
}

TEST_F(Commands, SetsTheStabiliserWithinReason) {
  ASSERT_TRUE(cell.await(cell->manual.set_stabiliser(cell.ada, cell.lease(), "support", 23.5)));
  EXPECT_EQ(world.support_set_degc, 23.5);
  EXPECT_EQ(cell.await(cell->manual.set_stabiliser(cell.ada, cell.lease(), "support", 200))
                .error()
                .reason,
            "SET_POINT");
  const auto oven = cell.await(cell->manual.set_stabiliser(cell.ada, cell.lease(), "oven", 23));
  EXPECT_EQ(oven.error().reason, "NO_STABILISER");
  EXPECT_EQ(oven.error().message, "the cell has no stabiliser 'oven', it has support");
}

TEST_F(Commands, ADatasetGoesOutAndComesBackExactly) {
  const auto run = cell.begin_run(lines_of(2, {1, -2}, true));
  cell.finish_run();
  const auto csv = cell.await(cell->datasets.export_csv({run.id}, false));
  ASSERT_TRUE(csv) << csv.error().message;
  const auto imported = cell.await(cell->datasets.import_csv(cell.ada, "again.csv", *csv, ""));
  ASSERT_TRUE(imported) << imported.error().message;
  EXPECT_EQ(imported->state, RunState::done);
  EXPECT_EQ(*cell.await(cell->datasets.export_csv({imported->id}, false)), *csv);
}

TEST_F(Commands, SteeringARunThatIsNotThereSaysSo) {
  EXPECT_EQ(cell.await(cell->runs.pause(cell.ada, RunId{99})).error().code, ErrorCode::not_found);
}

}  // namespace
}  // namespace driftwise::tests
