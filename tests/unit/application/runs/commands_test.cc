// What clients ask, refused or done.

#include <gmock/gmock.h>

#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

using testing::HasSubstr;

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

// A file that says nothing of itself: rows that this cell did not measure are not said to be its.
TEST_F(Commands, AnExportSaysWhichRowsThisCellDidNotMeasure) {
  const auto measured = cell.begin_run(lines_of(2, {1, -2}, true)).id;
  cell.finish_run();
  const auto import = [this](const std::string& csv) {
    return cell.await(cell->datasets.import_csv(cell.ada, "bare.csv", csv, ""))->id;
  };
  const std::string rows = "time_s,q1_mm,x_mm\n1,0,0\n2,1,1\n3,2,2\n";
  const auto bare = import(rows), with_parts = import(
                                      "# parts: t01=robot\ntime_s,q1_mm,x_mm,t01_degC\n"
                                      "1,0,0,20\n2,1,1,21\n3,2,2,22\n");
  const auto exported = [this](const std::vector<RunId>& runs) {
    return *cell.await(cell->datasets.export_csv(runs, false));
  };
  const auto n = [](RunId run) { return std::to_string(run.value); };
  EXPECT_THAT(exported({bare}), testing::Not(testing::AnyOf(HasSubstr("cell:"), HasSubstr("runs:"),
                                                            HasSubstr("compensation:"))));
  EXPECT_THAT(exported({bare}), testing::EndsWith(rows));
  EXPECT_THAT(exported({with_parts}), testing::Not(HasSubstr("cell:")));
  const auto files = exported({bare, with_parts});
  EXPECT_THAT(files, HasSubstr("# runs: " + n(bare) + ", " + n(with_parts) + "\n"));
  EXPECT_THAT(files, HasSubstr("# parts: t01=robot\n"));
  EXPECT_THAT(files, testing::Not(testing::AnyOf(HasSubstr("cell:"), HasSubstr("compensation:"))));
  const auto mixed = exported({measured, bare});
  EXPECT_THAT(mixed, HasSubstr("# cell: "));
  EXPECT_THAT(mixed, HasSubstr("# compensation: run " + n(measured) + " none, run " + n(bare) +
                               " imported\n"));
}

// Lines at the head of a file that a computation reads, of two files and of a file beside a run.
TEST_F(Commands, SeveralFilesAndRunsAreTakenTogetherWithWhatTheyState) {
  const auto measured = cell.begin_run(lines_of(2, {1, -2}, true)).id;
  cell.finish_run();
  const auto import = [this](const std::string& lines) {
    const std::string rows = "time_s,q1_mm,x_mm,t01_degC\n1,0,0,20\n2,1,1,21\n3,2,2,22\n";
    return cell.await(cell->datasets.import_csv(cell.ada, "f.csv", lines + rows, ""))->id;
  };
  const auto taken = [this](const std::vector<RunId>& runs) {
    return cell.await(cell->datasets.load(runs, ""));
  };
  const auto says = [](const Dataset& data, const std::string& key) {
    for (const auto& [found, value] : data.metadata)
      if (found == key) return value;
    return std::string();
  };
  const std::string yes = "# overruns: yes\n# parts: t01=air\n# measured_by: x=laser\n";
  const auto one = import(yes), two = import(yes), plain = import("# measured_by: x=laser\n");
  const auto both = taken({one, two});
  ASSERT_TRUE(both) << both.error().message;
  EXPECT_EQ(says(*both, "overruns"), "yes");
  EXPECT_EQ(says(*both, "parts"), "t01=air");
  EXPECT_EQ(says(*both, "measured_by"), "x=laser");
  EXPECT_EQ(taken({one, plain}).error().reason, "METADATA_DISAGREE");
  const auto beside = taken({measured, one});
  ASSERT_FALSE(beside);
  EXPECT_EQ(beside.error().reason, "METADATA_DISAGREE");
  EXPECT_THAT(beside.error().message,
              testing::StartsWith("run 2 states '# overruns: yes' and run 1 does not: "));
  const auto with_plain = taken({measured, plain});
  ASSERT_TRUE(with_plain) << with_plain.error().message;
  EXPECT_EQ(says(*with_plain, "left_out"), "measured_by of x: not stated by run 1");
}

TEST_F(Commands, SteeringARunThatIsNotThereSaysSo) {
  EXPECT_EQ(cell.await(cell->runs.pause(cell.ada, RunId{99})).error().code, ErrorCode::not_found);
}

}  // namespace
}  // namespace driftwise::tests
