// Whole campaigns on virtual time.

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

class Campaign : public testing::Test {
 protected:
  Folder folder;
  SmallWorld world;
  CellDescription description = small_cell(folder / "cell.sqlite");
  CellInMemory cell{world, description, kSqlite};
  std::vector<PointRecord> points(RunId run) { return *cell.await(cell.points(run, 0, 10'000)); }
  std::vector<AttemptRecord> attempts(RunId run) { return *cell.await(cell.attempts(run)); }
};

TEST_F(Campaign, MeasuresEveryRowOnceAndEndsAtZero) {
  const auto begun = cell.begin_run(lines_of(5, {-4, -2, 1, 4}, true));
  const auto run = cell.finish_run();
  EXPECT_EQ(run.state, RunState::done) << run.reason;
  EXPECT_EQ(run.id, begun.id);
  EXPECT_EQ(run.accepted, 25);
  EXPECT_EQ(run.place.next_row, 25);
  const auto all = points(run.id);
  ASSERT_EQ(all.size(), 25u);
  for (std::size_t i = 0; i < all.size(); ++i) EXPECT_EQ(all[i].row, static_cast<std::int64_t>(i));
  EXPECT_EQ(world.zeroings, 1);
  EXPECT_EQ(cell.events_named("run.closure").size(), 5u);  // the trajectory's own; none added
}

TEST_F(Campaign, JoinsWhatBelongsToAPoint) {
  const auto run = cell.begin_run(lines_of(1, {2, -3}, false));
  cell.finish_run();
  const auto point = points(run.id).front();
  const auto value = [&point](const char* name) {
    for (const auto& v : point.values)
      if (v.channel == name) return v.value;
    return kMissing;
  };
  EXPECT_NEAR(value("q1_mm"), 2, 100e-6);
  EXPECT_NEAR(value("x_mm"), 2, 300e-6);
  EXPECT_LT(value("x_std_nm"), 5);
  // The world's own law at the instant of the point: 20.1 degC + 0.5 K/h. Scans are 5 s apart: 0.7
  // mK.
  const double hours = seconds_from(point.measured.utc - kWorldBegin) / 3600;
  EXPECT_NEAR(value("t01_degC"), 20.1 + 0.5 * hours, 1e-3);
  EXPECT_NEAR(value("air_degC"), 20.5 + 0.5 * hours, 1e-3);
  EXPECT_NEAR(value("support_degC"), 23, 1e-9);
  EXPECT_GE(point.dwell_s, description.run.settle_s);
  ASSERT_EQ(point.commanded_mm, (std::vector<double>{2}));
}

TEST_F(Campaign, ReturnsToZeroAfterLinesThatBringNone) {
  const auto run = cell.begin_run(lines_of(3, {2, -3}, false));
  cell.finish_run();
  EXPECT_EQ(points(run.id).size(), 6u);
  EXPECT_EQ(cell.events_named("run.closure").size(), 3u);
}

TEST_F(Campaign, RereadsADisturbedGroupWithoutMoving) {
  const auto run = cell.begin_run(lines_of(1, {2, -3}, false));
  cell.until([&] { return cell.status().run->run.accepted == 1; });
  cell.until([&] { return cell.status().run->phase == "reading"; });
  const int moves = world.moves;
  world.disturbed_readings = 4;
  cell.finish_run();
  const auto tries = attempts(run.id);
  ASSERT_EQ(tries.size(), 3u);
  EXPECT_EQ(tries[1].verdict, Verdict::reread);
  EXPECT_EQ(tries[1].reason.substr(0, 6), "spread");
  EXPECT_EQ(tries[2].verdict, Verdict::accepted);
  EXPECT_EQ(tries[2].number, 2);
  EXPECT_EQ(world.moves, moves + 1);  // the return to zero only
}

TEST_F(Campaign, ReapproachesRequeuesAndGivesUpWithinTheBudgets) {
  world.disturbance_nm = 100;
  const auto run = cell.begin_run(lines_of(1, {2, -3}, false));
  cell.until([&] {
    return cell.status().run->phase == "reading" && cell.status().run->run.accepted == 0 &&
           world.zeroings == 1 && cell.status().run->row == 0 && world.moves > 1;
  });
  world.disturbed_readings = 4 * 12 + 4;  // until row 0 is given up; row 1 is disturbed in between
  const auto ended = cell.finish_run();
  EXPECT_EQ(ended.state, RunState::done);
  std::vector<Verdict> first_row;
  for (const auto& a : attempts(run.id))
    if (a.row == 0) first_row.push_back(a.verdict);
  const std::vector<Verdict> one_visit{Verdict::reread, Verdict::reread, Verdict::reapproach,
                                       Verdict::reread, Verdict::reread};
  ASSERT_GE(first_row.size(), 6u);
  for (std::size_t i = 0; i < one_visit.size(); ++i) EXPECT_EQ(first_row[i], one_visit[i]) << i;
  EXPECT_EQ(first_row[5], Verdict::requeued);
  EXPECT_EQ(ended.accepted + ended.given_up, 2);
  EXPECT_LE(first_row.size(), 12u);
}

TEST_F(Campaign, AMoveTakesAsLongAsItComesNearer) {
  auto request = application::CreateRun{};
  request.trajectory_text = lines_of(1, {4, -4}, false);
  request.rules = description.run;
  request.rules->move_timeout_s = 1;  // from 4 to -4 mm are 2.3 s
  const auto run = cell.try_run(request);
  ASSERT_TRUE(run);
  EXPECT_EQ(cell.finish_run().state, RunState::done);
  const auto tries = attempts(run->id);
  ASSERT_EQ(tries.size(), 2u);
  for (const auto& one : tries) EXPECT_EQ(one.verdict, Verdict::accepted) << one.reason;
}

TEST_F(Campaign, DoesNotReadAnAxisThatNeverSettles) {
  auto request = application::CreateRun{};
  request.trajectory_text = lines_of(1, {2}, false);
  request.rules = description.run;
  request.rules->move_timeout_s = 4;
  request.rules->in_position_nm = 1000;
  const auto run = cell.try_run(request);
  ASSERT_TRUE(run);
  cell.until([&] { return world.zeroings == 1; });
  world.creeping = true;
  cell.until([&] { return cell.status().run->run.hold.kind == RunHold::Kind::trouble; }, 100'000);
  EXPECT_NE(cell.status().run->run.reason.find("zero after line 1: quiet to"), std::string::npos)
      << "nor is it read at the zero";
  world.creeping = false;
  ASSERT_TRUE(cell.resume());
  const auto ended = cell.finish_run();
  EXPECT_EQ(ended.given_up, 1);
  const auto tries = attempts(run->id);
  ASSERT_EQ(tries.size(), 4u);
  EXPECT_EQ(tries[0].verdict, Verdict::reapproach);
  EXPECT_EQ(tries[1].verdict, Verdict::requeued);
  EXPECT_EQ(tries[3].verdict, Verdict::given_up);
  EXPECT_EQ(tries[0].reason.substr(0, 8), "quiet to");
}

TEST_F(Campaign, WaitsForTheStabiliserBeforeTheStart) {
  world.support_degc = 21;
  std::set<std::string> phases;
  const auto watch =
      cell->runs.watch([&](const application::RunProgress& p) { phases.insert(p.phase); });
  const auto run = cell.begin_run(lines_of(1, {2}, false));
  cell.until(
      [&] { return cell.status().run && cell.status().run->run.state == RunState::waiting; });
  EXPECT_NE(cell.status().run->run.reason.find("set-point"), std::string::npos);
  EXPECT_EQ(cell.finish_run().state, RunState::done);
  EXPECT_TRUE(phases.contains("waiting for the stabiliser"));
}

TEST_F(Campaign, FailsWithASentenceWhenTheDriftAtRestStaysTooFast) {
  world.nm_per_k = 30'000;  // 250 nm/min
  cell.begin_run(lines_of(1, {2}, false));
  const auto ended = cell.finish_run();
  EXPECT_EQ(ended.state, RunState::failed);
  EXPECT_NE(ended.reason.find("nm/min"), std::string::npos) << ended.reason;
  EXPECT_EQ(ended.accepted, 0);
}

TEST_F(Campaign, RecordsTheSlowChannelsRunOrNoRun) {
  cell.pass(100);
  EXPECT_GE(world.scans, 20);
  cell.begin_run(lines_of(1, {2}, false));
  cell.finish_run();
  const int scans = world.scans;
  cell.pass(100);
  EXPECT_GE(world.scans, scans + 20);
  const auto status = cell.status();
  ASSERT_GE(status.values.size(), 5u);
  for (const auto& value : status.values) EXPECT_FALSE(value.stale) << value.channel.name();
}

TEST_F(Campaign, TellsWatchersOnlyWhatIsOnDisk) {
  std::int64_t last_sequence = 0;
  bool behind = false;
  auto reading = *kSqlite(description.database, true);
  const auto watch = cell->runs.watch([&](const application::RunProgress& p) {
    EXPECT_GT(p.sequence, last_sequence);
    last_sequence = p.sequence;
    const auto stored = reading->runs().run(p.run.id);
    if (!stored || stored->accepted < p.run.accepted) behind = true;
  });
  cell.begin_run(lines_of(2, {2, -3}, true));
  cell.finish_run();
  EXPECT_FALSE(behind);
  EXPECT_GT(last_sequence, 10);
}

TEST_F(Campaign, EstimatesItsEnd) {
  cell.begin_run(lines_of(10, {2, -3, 1}, true));
  cell.until([&] { return cell.status().run->run.accepted == 20; });
  const auto estimate = cell.status().run->estimated_end;
  const auto asked_at = cell.now();
  const auto ended = cell.finish_run();
  EXPECT_NEAR(seconds_from(estimate - asked_at) / seconds_from(ended.ended - asked_at), 1, 0.15);
}

// Of both the run's own readings are what is shown: the recorder leaves them alone meanwhile.
TEST_F(Campaign, ShowsTheAxesAsNewAsTheLengths) {
  cell.begin_run(lines_of(10, {2, -3, 1}, true));
  cell.until([&] { return cell.status().run->run.accepted == 20; });
  const auto status = cell.status();
  int seen = 0;
  for (const auto& value : status.values) {
    const auto name = value.channel.name();
    if (name != "q1_mm" && name != "x_mm") continue;
    ++seen;
    EXPECT_LT(value.age_s, 5) << name;
    EXPECT_FALSE(value.stale) << name;
  }
  EXPECT_EQ(seen, 2);
}

TEST(CampaignAfterARestart, HasAnEndThatRestsOnTheRunsOnRecordAtOnce) {
  Folder folder;
  SmallWorld world;
  const auto description = small_cell(folder / "cell.sqlite");
  {
    CellInMemory cell(world, description, kSqlite);
    cell.begin_run(lines_of(2, {2, -3}, true));
    EXPECT_EQ(cell.finish_run().state, RunState::done);
    cell.begin_run(lines_of(2, {2, -3}, true));
    cell.until([&] { return cell.status().run->run.accepted == 2; });
  }
  CellInMemory cell(world, description, kSqlite, kWorldBegin + std::chrono::hours(1));
  cell.until([&] { return cell.status().run.has_value(); }, 10);
  EXPECT_EQ(cell.status().run->outlook.runs, 1);
  EXPECT_EQ(cell.finish_run().state, RunState::done);
}

TEST_F(Campaign, IsTheSameEveryTime) {
  const auto run = cell.begin_run(lines_of(2, {2, -3}, true));
  cell.finish_run();
  const auto csv = *cell.await(cell->datasets.export_csv({run.id}, false));
  Folder other_folder;
  SmallWorld other_world;
  CellInMemory other(other_world, small_cell(other_folder / "cell.sqlite"), kSqlite);
  const auto again = other.begin_run(lines_of(2, {2, -3}, true));
  other.finish_run();
  EXPECT_EQ(*other.await(other->datasets.export_csv({again.id}, false)), csv);
}

}  // namespace
}  // namespace driftwise::tests
