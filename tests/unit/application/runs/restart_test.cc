// Kill -9 at every crash point in turn, a real database, a world that goes on: no point lost, none
// doubled.

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <functional>
#include <map>

#include "server/application/motion/datum_opening.h"
#include "server/application/plumbing/crash_point.h"
#include "storage/sqlite_store.h"
#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/shared_world.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

const std::string kTrajectory = lines_of(2, {2, -3}, true);
constexpr std::int64_t kRows = 6;

// Runs the daemon in a child until it is done, or dies at the n-th passing of any crash point.
// True: it died.
// Readings and events go to disk by the clock and are many: `every` counts them too.
enum class Count { commits_of_the_run, every };
// A length jumps while the first line is measured, and the line is measured again.
enum class Jump { none, in_the_first_line };
bool daemon_dies(SharedWorld& world, const std::string& database, CellTime begin, int n,
                 bool begin_run, Count count = Count::commits_of_the_run, Jump jump = Jump::none) {
  const pid_t child = ::fork();
  if (child == 0) {
    int passed = 0;
    application::on_crash_point([&passed, n, count](std::string_view name) {
      const bool counts = count == Count::every ||
                          (!name.ends_with("_readings_commit") && !name.ends_with("_event_commit"));
      if (counts && ++passed == n) ::raise(SIGKILL);
    });
    auto description = small_cell(database);
    if (jump != Jump::none) description.text = "[closure]\nunexplained = \"repeat\"\n";
    CellInMemory cell(*world, description, kSqlite, begin);
    const auto watch = cell->runs.watch([&world, jump](const application::RunProgress& p) {
      world->told_accepted = std::max(world->told_accepted, p.run.accepted);
      if (jump == Jump::none || p.run.accepted != 2 || std::exchange(world->jumped, true)) return;
      world->zero_mm -= 0.010;
    });
    if (begin_run) {
      application::CreateRun request;
      request.trajectory_text = kTrajectory;
      request.request_id = "the-one";
      if (!cell.try_run(request)) ::_exit(3);
    }
    cell.finish_run();
    cell.shut_down();
    ::_exit(0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  if (WIFEXITED(status)) {
    EXPECT_EQ(WEXITSTATUS(status), 0);
    return false;
  }
  return true;
}

struct Found {
  std::optional<RunRecord> run;
  std::map<std::int64_t, int> points_of_row;
  int repeated = 0;
  std::vector<DatumRecord> data;
  std::vector<AttemptRecord> attempts;
};

Found look(const std::string& database) {
  Found found;
  auto store = *storage::open_sqlite_store(database, true);
  const auto runs = *store->runs().runs(10, 0);
  if (runs.empty()) return found;
  found.run = runs.front();
  const auto all_points = *store->points().points(runs.front().id, 0, 1000);
  const auto old = *store->closures().repeated_points(runs.front().id);
  for (const auto& point : all_points) {
    if (point.passage) continue;
    if (std::ranges::binary_search(old, point.id))
      ++found.repeated;
    else
      ++found.points_of_row[point.row];
  }
  found.data = *store->points().data(runs.front().id);
  found.attempts = *store->points().attempts(runs.front().id);
  return found;
}

// Kills at the n-th crash point, starts again, and judges by what an outside watcher had been told.
// False: the run was through before the n-th came.
bool survives(int n, Count count, Jump jump = Jump::none) {
  Folder folder;
  SharedWorld world;
  const auto database = folder / "cell.sqlite";
  if (!daemon_dies(world, database, kWorldBegin, n, true, count, jump)) return false;
  const auto between = look(database);
  const auto stored = static_cast<std::int64_t>(between.points_of_row.size());
  EXPECT_GE(stored + between.repeated, world->told_accepted)
      << "a point was acknowledged and is not there";
  if (!between.run || !is_over(between.run->state)) {
    EXPECT_FALSE(daemon_dies(world, database, kWorldBegin + std::chrono::hours(1), 1 << 30,
                             !between.run, count, jump));
  }
  const auto after = look(database);
  EXPECT_TRUE(after.run);
  if (!after.run) return true;
  EXPECT_EQ(after.run->state, RunState::done) << after.run->reason;
  EXPECT_EQ(static_cast<std::int64_t>(after.points_of_row.size()), kRows);
  for (const auto& [row, points] : after.points_of_row) EXPECT_EQ(points, 1) << "row " << row;
  EXPECT_EQ(after.run->accepted, kRows);
  if (jump == Jump::none && stored > 0 && stored < kRows) {
    EXPECT_GE(after.data.size(), 2u);
    EXPECT_EQ(after.data.back().reason, "restart after a kill");
    EXPECT_EQ(after.run->restarts, 1);
  }
  return true;
}

TEST(Restart, LosesAndDoublesNoPointAtAnyCommitOfTheRun) {
  int n = 1;
  for (;; ++n) {
    SCOPED_TRACE("killed at passing " + std::to_string(n));
    ASSERT_LT(n, 100);
    if (!survives(n, Count::commits_of_the_run)) break;
  }
  EXPECT_GT(n, 2 * kRows) << "the crash points are there at all";
}

TEST(Restart, LosesAndDoublesNoPointOfALineThatIsMeasuredAgain) {
  int n = 1, repeats = 0;
  for (;; ++n) {
    SCOPED_TRACE("killed at passing " + std::to_string(n));
    ASSERT_LT(n, 150);
    const auto survived = survives(n, Count::commits_of_the_run, Jump::in_the_first_line);
    if (!survived) break;
    ++repeats;
  }
  EXPECT_GT(repeats, 3 * kRows) << "the line was measured twice";
}

TEST(Restart, LosesAndDoublesNoPointWhenReadingsOrEventsWereOnTheirWay) {
  for (const int n : {3, 9, 15, 21, 27, 33}) {
    SCOPED_TRACE("killed at passing " + std::to_string(n));
    EXPECT_TRUE(survives(n, Count::every));
  }
}

TEST(Restart, ComparesTheZeroWithTheOneBefore) {
  Folder folder;
  SharedWorld world;
  const auto database = folder / "cell.sqlite";
  world->warming_k_per_h = 0;
  ASSERT_TRUE(daemon_dies(world, database, kWorldBegin, 11, true));
  world->zero_mm += 0.001;  // somebody touched the mirror: 1 um
  ASSERT_FALSE(daemon_dies(world, database, kWorldBegin + std::chrono::hours(1), 1 << 30, false));
  const auto after = look(database);
  ASSERT_EQ(after.data.size(), 2u);
  std::map<std::string, double> values;
  for (const auto& v : after.data.back().values) values[v.channel] = v.value;
  EXPECT_NEAR(values.at("zero_found_nm"), -1000,
              100);  // the reference and the holding repeat within tens of nm
  EXPECT_NEAR(values.at("zero_predicted_nm"), 0, 30);
  auto store = *storage::open_sqlite_store(database, true);
  int surprised = 0;
  const auto events = *store->events().events(EventId{0}, 10'000);
  for (const auto& event : events) surprised += event.what == "zero.surprising";
  EXPECT_EQ(surprised, 1);
}

// Runs the daemon in a child until `when` says that it is killed.
void kill_when(SharedWorld& world, const std::string& database, CellTime begin,
               const std::string& new_run, std::function<bool(CellInMemory&)> when) {
  const pid_t child = ::fork();
  if (child == 0) {
    CellInMemory cell(*world, small_cell(database), kSqlite, begin);
    if (!new_run.empty()) cell.begin_run(new_run);
    cell.until([&] { return cell.status().run && when(cell); });
    ::raise(SIGKILL);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status));
}

std::vector<std::int64_t> suspect_rows(const std::string& database) {
  std::vector<std::int64_t> rows;
  auto store = *storage::open_sqlite_store(database, true);
  const auto marks = store->remarks().exclusions(RunId{1}).value();
  for (const auto& mark : marks)
    if (mark.suspect) rows.insert(rows.end(), mark.rows.begin(), mark.rows.end());
  return rows;
}

// Killed in the middle of a line, then once more between the zeroing and the commit of its datum.
TEST(Restart, KeepsWhatTheOldZeroWasWhenAZeroingWasInterrupted) {
  Folder folder;
  SharedWorld world;
  const auto database = folder / "cell.sqlite";
  world->warming_k_per_h = 0;
  kill_when(world, database, kWorldBegin, kTrajectory,
            [](CellInMemory& cell) { return cell.status().run->run.accepted == 2; });
  world->zero_mm += 0.001;  // somebody touched the mirror: 1 um
  const int zeroings = world->zeroings;
  kill_when(world, database, kWorldBegin + std::chrono::hours(1), "",
            [&](CellInMemory&) { return world->zeroings == zeroings + 1; });
  ASSERT_EQ(look(database).data.size(), 1u) << "zeroed, and no datum of it";
  ASSERT_FALSE(daemon_dies(world, database, kWorldBegin + std::chrono::hours(2), 1 << 30, false));
  const auto after = look(database);
  EXPECT_EQ(after.run->state, RunState::done);
  ASSERT_EQ(after.data.size(), 2u);
  std::map<std::string, double> values;
  for (const auto& v : after.data.back().values) values[v.channel] = v.value;
  EXPECT_NEAR(values["zero_found_nm"], -1000, 100) << "as the first attempt had it";
  EXPECT_FALSE(values.contains("x_mm")) << "nobody can read the old zero any more";
  const auto rows = suspect_rows(database);
  EXPECT_NE(std::ranges::find(rows, 1), rows.end()) << "measured since the last good zero";
  auto store = *storage::open_sqlite_store(database, true);
  const auto events = *store->events().events(EventId{0}, 10'000);
  EXPECT_TRUE(std::ranges::any_of(events, [](const EventRecord& event) {
    return event.what == "data.suspect" && event.detail.starts_with("rows 1-2 of run 1 ");
  })) << "counted from 1, as everywhere that people read";
}

// A lost beam is zeroed without a comparison: that zeroing took the old zero away all the same.
TEST(Restart, ComparesNothingWhenTheBeamWasLostAndTheZeroingInterrupted) {
  Folder folder;
  SharedWorld world;
  const auto database = folder / "cell.sqlite";
  kill_when(world, database, kWorldBegin, kTrajectory,
            [&, zeroed = -1](CellInMemory& cell) mutable {
              if (zeroed < 0 && cell.status().run->run.accepted == 2) {
                zeroed = world->zeroings;
                world->beam_lost = true;
              }
              return zeroed >= 0 && world->zeroings > zeroed;
            });
  ASSERT_EQ(look(database).data.size(), 1u) << "zeroed, and no datum of it";
  ASSERT_FALSE(daemon_dies(world, database, kWorldBegin + std::chrono::hours(1), 1 << 30, false));
  const auto after = look(database);
  EXPECT_EQ(after.run->state, RunState::done);
  ASSERT_EQ(after.data.size(), 2u);
  for (const auto& v : after.data.back().values) EXPECT_NE(v.channel, "zero_found_nm");
}

// Lines without a zero among their rows end with a return to zero.
TEST(Restart, DoesNotDoubtRowsThatAStoredReturnToZeroHasConfirmed) {
  Folder folder;
  SharedWorld world;
  const auto database = folder / "cell.sqlite";
  world->warming_k_per_h = 0;
  kill_when(world, database, kWorldBegin, lines_of(2, {2, -3}, false), [](CellInMemory& cell) {
    return cell.status().run->run.accepted == 2 && cell.status().run->line == 2;
  });
  world->zero_mm += 0.001;  // touched after the return to zero
  ASSERT_FALSE(daemon_dies(world, database, kWorldBegin + std::chrono::hours(1), 1 << 30, false));
  EXPECT_EQ(look(database).run->state, RunState::done);
  EXPECT_EQ(suspect_rows(database), std::vector<std::int64_t>{});
}

TEST(Restart, ARestGoesOnAfterAKillAndSaysSinceWhen) {
  Folder folder;
  SharedWorld world;
  const auto database = folder / "cell.sqlite";
  world->warming_k_per_h = 0;
  const pid_t child = ::fork();
  if (child == 0) {
    CellInMemory cell(*world, small_cell(database), kSqlite);
    if (!cell.await(cell->commissioning.begin_rest(cell.ada, {20, 0.5, 600}))) ::_exit(3);
    cell.pass(1800);
    ::raise(SIGKILL);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status));
  CellInMemory cell(*world, small_cell(database), kSqlite, kWorldBegin + std::chrono::hours(1));
  cell.until([&] { return cell.events_named("rest.continued").size() == 1; });
  EXPECT_NE(cell.events_named("rest.continued").front().find("since 2026-11-21T08:00"),
            std::string::npos);
  cell.pass(3600);
  const auto report = cell.await(cell->commissioning.rest());
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_LT(report->begin, kWorldBegin + std::chrono::minutes(1));
  EXPECT_EQ(report->end.utc_ns, 0);
  EXPECT_EQ(report->begun_by, "ada");
  EXPECT_EQ(report->limits.window_s, 600);
  EXPECT_TRUE(report->warm) << report->sentence;
  ASSERT_TRUE(cell.await(cell->commissioning.end_rest(cell.ada)));
  EXPECT_EQ(cell.await(cell->commissioning.rest())->end_reason, "ended by ada");
}

TEST(Restart, RecordsTheInterruptedAttempt) {
  Folder folder;
  SharedWorld world;
  const auto database = folder / "cell.sqlite";
  ASSERT_TRUE(daemon_dies(world, database, kWorldBegin, 11, true));
  ASSERT_FALSE(daemon_dies(world, database, kWorldBegin + std::chrono::hours(1), 1 << 30, false));
  int interrupted = 0;
  const auto found = look(database);
  for (const auto& attempt : found.attempts) interrupted += attempt.verdict == Verdict::interrupted;
  EXPECT_EQ(interrupted, 1);
}

TEST(Restart, APauseThatWaitsForThePointUnderWayIsKeptWhenTheDaemonEnds) {
  Folder folder;
  SmallWorld world;
  const auto database = folder / "cell.sqlite";
  {
    CellInMemory cell(world, small_cell(database), kSqlite);
    const auto run = cell.begin_run(kTrajectory).id;
    cell.until([&] { return cell.status().run->run.accepted == 2; });
    ASSERT_TRUE(cell.await(cell->runs.pause(cell.ada, run)));
    ASSERT_EQ(cell.status().run->run.state, RunState::running) << "the point is under way";
    cell.shut_down();
    EXPECT_FALSE(cell.halt_not_on_record());
  }
  const auto stored = *look(database).run;
  EXPECT_EQ(stored.state, RunState::paused);
  EXPECT_EQ(stored.hold.who, "ada");
  CellInMemory cell(world, small_cell(database), kSqlite, kWorldBegin + std::chrono::hours(1));
  cell.until([&] { return cell.status().run.has_value(); });
  cell.pass(600);
  EXPECT_EQ(cell.status().run->run.accepted, stored.accepted);
}

TEST(Restart, APausedRunStaysPausedUntilSomebodyResumesIt) {
  Folder folder;
  SmallWorld world;
  const auto database = folder / "cell.sqlite";
  RunId run;
  {
    CellInMemory cell(world, small_cell(database), kSqlite);
    run = cell.begin_run(kTrajectory).id;
    cell.until([&] { return cell.status().run->run.accepted == 2; });
    ASSERT_TRUE(cell.await(cell->runs.pause(cell.ada, run)));
    cell.until([&] { return cell.status().run->run.state == RunState::paused; });
  }
  CellInMemory cell(world, small_cell(database), kSqlite, kWorldBegin + std::chrono::hours(1));
  cell.until([&] { return cell.status().run.has_value(); });
  cell.pass(600);
  EXPECT_EQ(cell.status().run->run.state, RunState::paused);
  ASSERT_TRUE(cell.resume());
  const auto ended = cell.finish_run();
  EXPECT_EQ(ended.state, RunState::done);
  EXPECT_EQ(ended.accepted, kRows);
  EXPECT_EQ(cell.await(cell.datums(run))->back().reason, "restart");
}

// Trouble before the datum is opened takes nothing from what it is opened for.
TEST(Restart, ComparesTheZeroAlsoAfterATroubleBeforeItsFirstMotion) {
  Folder folder;
  SmallWorld world;
  world.warming_k_per_h = 0;
  const auto description = small_cell(folder / "cell.sqlite");
  {
    CellInMemory cell{world, description, kSqlite};
    cell.begin_run(lines_of(2, {2, -3}, true));
    cell.until([&] { return cell.status().run->run.accepted == 2; });
  }
  world.zero_mm += 0.001;
  world.referenced = false;
  world.scanner_away = true;
  CellInMemory cell{world, description, kSqlite, kWorldBegin + std::chrono::hours(1)};
  cell.pass(120);
  EXPECT_EQ(cell.status().run->run.state, RunState::waiting);
  world.scanner_away = false;
  cell.until([&] { return cell.status().run->run.state == RunState::paused; });
  ASSERT_TRUE(cell.resume());
  EXPECT_EQ(cell.finish_run().state, RunState::done);
  const auto data = *cell.await(cell.datums(RunId{1}));
  ASSERT_EQ(data.size(), 2u);
  EXPECT_EQ(data[1].reason, "restart");
  const double* found_nm = application::find_value(data[1].values, "zero_found_nm");
  ASSERT_NE(found_nm, nullptr) << "the old zero is not compared";
  EXPECT_NEAR(*found_nm, -1000, 100);
  EXPECT_EQ(suspect_rows(folder / "cell.sqlite"), (std::vector<std::int64_t>{0, 1}));
}

}  // namespace
}  // namespace driftwise::tests
