// A force that changes in the middle of a run: by an actuator, by a person, over restarts.

#include <gmock/gmock.h>

#include "server/application/motion/loading.h"
#include "server/application/plumbing/crash_point.h"
#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

using testing::HasSubstr;

const std::string kTwoForces =
    "q1_mm,set,line,zero,force_N\n"
    "0,calibration,1,1,0\n2,calibration,1,0,0\n"
    "0,calibration,2,1,2.305\n-3,validation,2,0,2.305\n";

double force_of(const PointRecord& point) {
  for (const auto& value : point.values)
    if (value.channel == "force_N") return value.value;
  return kMissing;
}

std::vector<double> forces(CellInMemory& cell, RunId run) {
  std::vector<double> out;
  const auto points = cell.await(cell.points(run, 0, 100));
  for (const auto& point : *points) out.push_back(force_of(point));
  return out;
}

bool waits_for_a_person(CellInMemory& cell) {
  const auto run = cell.status().run;
  return run && run->phase == "waiting for a person";
}

// At the end of the run, which asks for it.
void unload(CellInMemory& cell, RunId run) {
  cell.until([&] { return waits_for_a_person(cell) && cell.status().run->run.accepted == 4; });
  ASSERT_TRUE(cell.await(cell->runs.confirm_force(cell.ada, run, 0)));
}

TEST(HangSentence, SaysNewtonAndGram) {
  // The study's own: 12 weights, 235.280 g at g = 9.81 m/s2 are 2.305 N (to 0.3 g by its rounding).
  const LoadDescription study{4.0, 0, 9.81};
  EXPECT_EQ(application::hang_sentence(2.305, study), "hang 2.305 N (235 g)");
  EXPECT_EQ(application::hang_sentence(0, study), "take every weight off: 0 N");
}

TEST(Force, IsChangedByTheActuatorBetweenTwoPoints) {
  Folder folder;
  SmallWorld world;
  CellInMemory cell(world, small_cell_with_load(folder / "cell.sqlite", true), kSqlite);
  const auto run = cell.begin_run(kTwoForces);
  const auto done = cell.finish_run();
  EXPECT_EQ(done.state, RunState::done) << done.reason;
  EXPECT_EQ(world.loads, 2) << "nothing hung there at the start, so 0 N needed no change; at the "
                               "end the weights are taken off";
  EXPECT_EQ(forces(cell, run.id), (std::vector<double>{0, 0, 2.305, 2.305}));
  EXPECT_EQ(cell.events_named("load.changed").size(), 2u);
  const auto data = cell.await(cell.datums(run.id));
  ASSERT_EQ(data->size(), 1u);
  bool datum_knows = false;
  for (const auto& value : data->front().values) datum_knows |= value.channel == "force_N";
  EXPECT_TRUE(datum_knows);
}

// While weights are on their way there is no force to be read: that is no fault of anything.
TEST(Force, ThatTheActuatorChangesRaisesNoAlarm) {
  Folder folder;
  SmallWorld world;
  auto description = small_cell_with_load(folder / "cell.sqlite", true);
  for (auto& device : description.devices)
    if (device.kind == "load-actuator") {
      device.period_s = 10;
      device.max_age_s = 15;  // as the shipped Micro-Nano cell; a change takes 20 s here
    }
  CellInMemory cell(world, description, kSqlite);
  cell.begin_run(
      "q1_mm,set,line,zero,force_N\n0,calibration,1,1,0\n2,calibration,1,0,0\n"
      "0,calibration,2,1,2.305\n-3,validation,2,0,2.305\n0,calibration,3,1,0.768\n"
      "1,validation,3,0,0.768\n0,calibration,4,1,3.842\n1,calibration,4,0,3.842\n");
  EXPECT_EQ(cell.finish_run().state, RunState::done);
  EXPECT_GE(world.loads, 3);
  cell.pass(30);
  const auto alarms = cell.await(cell->alarms.list(true, 100));
  ASSERT_TRUE(alarms);
  for (const auto& alarm : *alarms) ADD_FAILURE() << alarm.kind << ": " << alarm.message;
}

TEST(Force, WaitsForThePersonWhoHangsTheWeights) {
  Folder folder;
  SmallWorld world;
  CellInMemory cell(world, small_cell_with_load(folder / "cell.sqlite", false), kSqlite);
  const auto run = cell.begin_run(kTwoForces);
  cell.until([&] { return waits_for_a_person(cell); });
  // Nobody has said yet what hangs there: the first row's 0 N is asked for too.
  EXPECT_THAT(cell.status().run->run.reason, HasSubstr("take every weight off: 0 N"));
  ASSERT_TRUE(cell.await(cell->runs.confirm_force(cell.ada, run.id, 0)));
  cell.until([&] { return waits_for_a_person(cell) && cell.status().run->run.accepted == 2; });
  EXPECT_EQ(cell.status().run->run.state, RunState::waiting);
  EXPECT_EQ(cell.status().run->run.reason,
            "hang 2.305 N (235 g), then: driftwise run confirm 1 --force 2.305");

  const auto wrong = cell.await(cell->runs.confirm_force(cell.ada, run.id, 1.5));
  EXPECT_EQ(wrong.error().reason, "WRONG_FORCE");
  EXPECT_THAT(wrong.error().message, HasSubstr("hang 2.305 N (235 g)"));
  ASSERT_TRUE(cell.await(cell->runs.confirm_force(cell.ada, run.id, 2.305)));
  unload(cell, run.id);
  const auto done = cell.finish_run();
  EXPECT_EQ(done.state, RunState::done) << done.reason;
  EXPECT_EQ(forces(cell, run.id), (std::vector<double>{0, 0, 2.305, 2.305}));
  EXPECT_EQ(cell.events_named("load.confirmed").size(), 3u);
}

TEST(Force, RefusesAConfirmationThatNobodyAskedFor) {
  Folder folder;
  SmallWorld world;
  CellInMemory cell(world, small_cell_with_load(folder / "cell.sqlite", true), kSqlite);
  const auto run = cell.begin_run(kTwoForces);
  EXPECT_EQ(cell.await(cell->runs.confirm_force(cell.ada, run.id, 2.305)).error().reason,
            "NO_FORCE_WANTED");
  cell.finish_run();
  EXPECT_EQ(cell.await(cell->runs.confirm_force(cell.ada, run.id, 2.305)).error().reason,
            "RUN_NOT_UNDER_WAY");
}

TEST(Force, OfAPersonIsKnownAfterARestart) {
  Folder folder;
  SmallWorld world;
  const auto description = small_cell_with_load(folder / "cell.sqlite", false);
  CellTime later = kWorldBegin;
  RunId run;
  {
    CellInMemory cell(world, description, kSqlite);
    run = cell.begin_run(kTwoForces).id;
    cell.until([&] { return waits_for_a_person(cell); });
    ASSERT_TRUE(cell.await(cell->runs.confirm_force(cell.ada, run, 0)));
    cell.until([&] { return waits_for_a_person(cell) && cell.status().run->run.accepted == 2; });
    later = cell.now() + std::chrono::seconds(60);
  }  // ends while it waits
  CellInMemory cell(world, description, kSqlite, later);
  cell.until([&] { return waits_for_a_person(cell); });
  EXPECT_THAT(cell.status().run->run.reason, HasSubstr("hang 2.305 N"))
      << "0 N is known, so only the change is asked for";
  ASSERT_TRUE(cell.await(cell->runs.confirm_force(cell.ada, run, 2.305)));
  unload(cell, run);
  EXPECT_EQ(cell.finish_run().state, RunState::done);
  EXPECT_EQ(forces(cell, run), (std::vector<double>{0, 0, 2.305, 2.305}));
}

// Ada confirms the force that the run waits for, and bob aborts it meanwhile.
class ConfirmedBesideAnAbort : public testing::Test {
 protected:
  ~ConfirmedBesideAnAbort() override { application::on_crash_point({}); }
  void wait_for_the_person() {
    run = cell.begin_run(kTwoForces).id;
    cell.until([&] { return waits_for_a_person(cell); });
  }
  // Once, when the writer comes to this point.
  void at(const char* crash_point, std::function<void()> act) {
    application::on_crash_point([this, crash_point, act](std::string_view name) {
      if (name == crash_point && !std::exchange(acted, true)) act();
    });
  }

  Folder folder;
  SmallWorld world;
  CellInMemory cell{world, small_cell_with_load(folder / "cell.sqlite", false), kSqlite};
  RunId run;
  bool acted = false;
};

TEST_F(ConfirmedBesideAnAbort, IsRefusedWhenTheRunEndsWhileTheWordIsStored) {
  wait_for_the_person();
  at("before_readings_commit", [this] {
    static_cast<void>(cell.await(cell->runs.abort({"bob", "peer", {}}, run, "enough")));
    cell.until([this] { return !cell.status().run; });
  });
  const auto confirmed = cell.await(cell->runs.confirm_force(cell.ada, run, 0));
  ASSERT_TRUE(acted);
  ASSERT_FALSE(confirmed);
  EXPECT_EQ(confirmed.error().reason, "RUN_NOT_UNDER_WAY");
  EXPECT_EQ(cell.await(cell.run(run))->state, RunState::aborted);
}

TEST_F(ConfirmedBesideAnAbort, IsRefusedWhenTheRunIsAlreadyAborted) {
  wait_for_the_person();
  std::optional<Result<RunRecord>> confirmed;
  at("before_run_state_commit",
     [&] { confirmed = cell.await(cell->runs.confirm_force(cell.ada, run, 0)); });
  static_cast<void>(cell.await(cell->runs.abort({"bob", "peer", {}}, run, "enough")));
  cell.until([&] { return confirmed && !cell.status().run; });
  ASSERT_FALSE(*confirmed);
  EXPECT_EQ(confirmed->error().reason, "RUN_ABORTED");
  EXPECT_EQ(cell.await(cell.run(run))->state, RunState::aborted);
}

TEST(Force, IsWaitedForNoLongerWhenTheRunIsAborted) {
  Folder folder;
  SmallWorld world;
  CellInMemory cell(world, small_cell_with_load(folder / "cell.sqlite", false), kSqlite);
  const auto run = cell.begin_run(kTwoForces);
  cell.until([&] { return waits_for_a_person(cell); });
  ASSERT_TRUE(cell.await(cell->runs.abort(cell.ada, run.id, "enough")));
  EXPECT_EQ(cell.finish_run().state, RunState::aborted);
}

}  // namespace
}  // namespace driftwise::tests
