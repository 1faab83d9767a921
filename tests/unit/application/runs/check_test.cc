// The cell judges the model that serves after every run, and connects its devices by itself.

#include <gmock/gmock.h>

#include "server/compensation/target.h"
#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

class Check : public testing::Test {
 protected:
  RunRecord measure(int lines) {
    cell.begin_run(lines_of(lines, {2, -3, 1, -1, 3, -2}, true));
    return cell.finish_run();
  }
  void learn_and_serve() {
    const auto run = measure(14);
    application::FitRequest request;
    request.runs = {run.id};
    request.formula = "q ~ x + T";
    const auto model = cell.await(cell->models.fit(cell.ada, request));
    ASSERT_TRUE(model) << model.error().message;
    ASSERT_TRUE(cell.await(cell->promotions.promote(cell.ada, model->id, true)));
    cell.pass(60);
  }
  Folder folder;
  SmallWorld world;
  CellInMemory cell{world, small_cell(folder / "cell.sqlite"), kSqlite};
};

TEST_F(Check, LeavesARobotThatIsAsItWasAlone) {
  learn_and_serve();
  measure(4);
  cell.pass(60);
  EXPECT_THAT(cell.events_named("check.in_control"),
              testing::ElementsAre("run 2 is as model 1 says"));
  EXPECT_THAT(cell.status().attention, IsEmpty());
  const auto check = cell.await(cell->checks.check_model({}, {}));
  ASSERT_TRUE(check) << check.error().message;
  ASSERT_EQ(check->runs.size(), 1u);
  EXPECT_EQ(check->runs[0].id, RunId{2});
}

TEST_F(Check, SaysRecalibrateNowOfARobotThatDriftsOtherwise) {
  learn_and_serve();
  world.nm_per_k = 1500;  // an arm that came loose: ten times the warming's effect
  world.warming_k_per_h = 3;
  measure(4);
  cell.pass(60);
  ASSERT_EQ(cell.events_named("check.recalibrate").size(), 1u);
  ASSERT_EQ(cell.status().attention.size(), 1u);
  EXPECT_THAT(cell.status().attention[0],
              HasSubstr("recalibrate now: the robot no longer does what model 1 says: run 2: q1"));
  // A new model of the robot as it is now, and nothing is wrong any more.
  learn_and_serve();
  EXPECT_THAT(cell.status().attention, IsEmpty());
}

TEST_F(Check, FlagsTheTargetsOfADoubtfulModelAndChangesNoNumber) {
  learn_and_serve();
  const auto target = [this] {
    compensation::TargetRequest request;
    request.set(compensation::Variable::x, 1.0);
    return compensation::compute_target(*cell->targets.snapshots().read(), request);
  };
  EXPECT_EQ(target().flags & compensation::kDoubtfulModel, 0u);
  world.nm_per_k = 1500;
  world.warming_k_per_h = 3;
  measure(4);
  cell.pass(60);
  const auto snapshot = cell->targets.snapshots().read();
  compensation::TargetRequest request;
  request.set(compensation::Variable::x, 1.0);
  const auto flagged = compensation::compute_target(*snapshot, request);
  EXPECT_NE(flagged.flags & compensation::kDoubtfulModel, 0u);
  EXPECT_THAT(compensation::describe_flags(*snapshot, flagged), HasSubstr("DOUBTFUL_MODEL"));
  auto trusted = *snapshot;
  trusted.doubtful = false;
  const auto same = compensation::compute_target(trusted, request);
  EXPECT_EQ(same.q_mm[0], flagged.q_mm[0]);
  EXPECT_EQ(same.u_nm[0], flagged.u_nm[0]);
  learn_and_serve();
  EXPECT_EQ(target().flags & compensation::kDoubtfulModel, 0u) << "another model serves";
}

TEST_F(Check, WithoutAModelThereIsNothingToSay) {
  measure(2);
  cell.pass(60);
  EXPECT_EQ(cell.await(cell->checks.check_model({}, {})).error().reason, "NO_MODEL");
  EXPECT_THAT(cell.events_named("check.in_control"), IsEmpty());
}

TEST_F(Check, DevicesAreConnectedFromTheStart) {
  cell.pass(2);
  EXPECT_THAT(cell.events_named("device.lost"), IsEmpty());
  world.laser_away = true;  // no run: nobody but the keeper would see it
  cell.pass(30);
  ASSERT_EQ(cell.events_named("device.lost").size(), 1u);
  EXPECT_THAT(cell.status().attention, testing::Contains(HasSubstr("laser")));
  world.laser_away = false;
  cell.pass(200);
  EXPECT_EQ(cell.events_named("device.back").size(), 1u);
  EXPECT_THAT(cell.status().attention, IsEmpty());
}

}  // namespace
}  // namespace driftwise::tests
