// The promise: what the store acknowledged is on the disk, whole and once, whenever the power
// fails. Each case lets a run of points work on a disk that forgets unsynced writes, cuts the power
// during one change, and judges what is left against what had been acknowledged.

#include <cstdlib>
#include <optional>

#include "tests/faults/unsynced_vfs.h"
#include "tests/unit/storage/store_fixture.h"

namespace driftwise::faults {
namespace {

using storage::at_s;
using storage::example_commit;
using storage::open_sqlite_store;
using storage::TemporaryFolder;

struct Acknowledged {
  std::optional<RunId> run;
  std::optional<DatumId> datum;
  std::int64_t points = 0, appended = 0, events = 0;
};

constexpr int kSessions = 2, kPointsPerSession = 6;

// Two sessions of a daemon: points, recorder, events, checkpoints, an orderly end. Ends at the
// first failure.
Acknowledged work(const std::string& path, const std::string& vfs) {
  Acknowledged seen;
  for (int session = 0; session < kSessions; ++session) {
    auto opened = open_sqlite_store(path, false, {.vfs = vfs, .checkpoint_pages = 25});
    if (!opened) return seen;
    Store& store = **opened;
    if (!seen.run) {
      const auto run = store.runs().create_run(storage::example_run());
      if (!run) return seen;
      seen.run = run->id;
    }
    const auto datum = store.points().open_datum(storage::example_datum(*seen.run));
    if (!datum) return seen;
    seen.datum = *datum;
    for (int i = 0; i < kPointsPerSession; ++i) {
      if (!store.points().commit(example_commit(*seen.run, *datum, seen.points, 2))) return seen;
      ++seen.points;
      (void)store.idle();  // its failure must cost nothing
      const Reading scan{"support",
                         at_s(1e5 + static_cast<double>(seen.appended)).utc,
                         at_s(1e5).utc,
                         seen.appended,
                         {{"support_degC", 20.5}}};
      if (!store.readings().append(std::vector{scan}, {})) return seen;
      ++seen.appended;
    }
    if (!store.events().add_event({{}, at_s(1), "daemon", "", "session.ended", "", seen.run}))
      return seen;
    ++seen.events;
  }
  return seen;
}

void expect_intact(const std::string& path) {
  storage::Database db(path, SQLITE_OPEN_READWRITE, "");
  storage::Query check(db, "PRAGMA integrity_check");
  ASSERT_TRUE(check.row());
  EXPECT_EQ(check.text(0), "ok");
  storage::Query foreign(db, "PRAGMA foreign_key_check");
  EXPECT_FALSE(foreign.row());
}

// At most one more of everything than was acknowledged: the call under way when the power failed.
void judge(const std::string& path, const Acknowledged& seen) {
  auto opened = open_sqlite_store(path, false);
  ASSERT_TRUE(opened) << opened.error().message;
  Store& store = **opened;
  if (!seen.run) return;
  const auto points = store.points().points(*seen.run, 0, 0).value();
  const auto count = static_cast<std::int64_t>(points.size());
  EXPECT_GE(count, seen.points) << "an acknowledged point is lost";
  EXPECT_LE(count, seen.points + 1);
  for (std::int64_t row = 0; row < count; ++row) {
    const PointRecord& point = points[static_cast<std::size_t>(row)];
    EXPECT_EQ(point.row, row) << "lost or doubled";
    EXPECT_EQ(point.values.size(), 12u);
    EXPECT_EQ(point.commanded_mm.size(), 1u);
  }
  const RunRecord run = store.runs().run(*seen.run).value();
  EXPECT_EQ(run.accepted, count);
  EXPECT_EQ(run.attempts, count);
  EXPECT_EQ(run.place.next_row, count);
  EXPECT_EQ(store.points().attempts(*seen.run)->size(), points.size());
  const auto readings = [&](const char* device) {
    return static_cast<std::int64_t>(
        store.readings().readings(device, {0}, at_s(1e9).utc, 0)->size());
  };
  EXPECT_EQ(readings("laser-x"), 2 * count);
  EXPECT_EQ(readings("axis"), 2 * count);
  EXPECT_EQ(readings("scanner"), count);
  EXPECT_GE(readings("support"), seen.appended);
  EXPECT_LE(readings("support"), seen.appended + 1);
  EXPECT_EQ(static_cast<std::int64_t>(store.readings().moves({0}, at_s(1e9).utc)->size()), count);
  EXPECT_GE(static_cast<std::int64_t>(store.events().events({0}, 0)->size()), seen.events);
  // And the run goes on.
  const auto datum = store.points().open_datum(storage::example_datum(*seen.run, 1e4));
  ASSERT_TRUE(datum) << datum.error().message;
  const auto next = store.points().commit(example_commit(*seen.run, *datum, count, 2));
  EXPECT_TRUE(next) << next.error().message;
}

std::int64_t changes_without_a_cut() {
  static const std::int64_t count = [] {
    const TemporaryFolder folder;
    const UnsyncedVfs disk("whole");
    const Acknowledged seen = work(folder / "cell.db", disk.name());
    EXPECT_EQ(seen.points, kSessions * kPointsPerSession);
    EXPECT_EQ(seen.events, kSessions);
    return disk.changes();
  }();
  return count;
}

void cut_and_judge(std::int64_t change, const PowerCut& cut, bool shm_garbage) {
  SCOPED_TRACE("cut at change " + std::to_string(change) + " of " +
               std::to_string(changes_without_a_cut()) + ", survivors " +
               std::to_string(static_cast<int>(cut.survivors)) + ", seed " +
               std::to_string(cut.seed) + ", sectors of " + std::to_string(cut.sector_bytes));
  const TemporaryFolder before, after;
  Acknowledged seen;
  {
    UnsyncedVfs disk("cut");
    disk.cut_power_at(change);
    seen = work(before / "cell.db", disk.name());
    disk.write_survivors(after / "", cut, shm_garbage);
  }
  judge(after / "cell.db", seen);
  expect_intact(after / "cell.db");
}

TEST(PowerCut, LosesNothingAcknowledgedWhenNoUnsyncedWriteArrived) {
  RecordProperty("faults", static_cast<int>((changes_without_a_cut() + 2) / 3));
  for (std::int64_t change = 1; change <= changes_without_a_cut() && !testing::Test::HasFailure();
       change += 3)
    cut_and_judge(change, {.survivors = Survivors::none, .seed = 0}, false);
}

TEST(PowerCut, LosesNothingAcknowledgedWhenEveryWriteArrived) {
  RecordProperty("faults", static_cast<int>((changes_without_a_cut() + 5) / 7));
  for (std::int64_t change = 2; change <= changes_without_a_cut() && !testing::Test::HasFailure();
       change += 7)
    cut_and_judge(change, {.survivors = Survivors::all, .seed = 0}, true);
}

TEST(PowerCut, LosesNothingAcknowledgedWhateverSectorsArrived) {
  // DRIFTWISE_POWER_CUTS=20000 for a long run.
  const char* wanted = std::getenv("DRIFTWISE_POWER_CUTS");
  const int cuts = wanted == nullptr ? 150 : std::atoi(wanted);
  const char* seed = std::getenv("DRIFTWISE_POWER_CUT_SEED");
  std::mt19937_64 random(seed == nullptr ? 20261121 : std::strtoull(seed, nullptr, 10));
  RecordProperty("faults", cuts);
  for (int i = 0; i < cuts && !testing::Test::HasFailure(); ++i) {
    const auto total = static_cast<std::uint64_t>(changes_without_a_cut());
    const auto change = static_cast<std::int64_t>(1 + random() % total);
    cut_and_judge(change,
                  {.survivors = Survivors::random,
                   .seed = random(),
                   .sector_bytes = i % 2 == 0 ? 512u : 4096u},
                  i % 3 == 0);
  }
}

// The judge must be able to say no: a log that is not synced with each commit loses what it
// acknowledged.
TEST(PowerCut, WouldBeSeenIfCommitsWereNotSynced) {
  const TemporaryFolder before, after;
  {
    UnsyncedVfs disk("lazy");
    storage::Database db(before / "lazy.db", SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, "lazy");
    db.execute("PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL; CREATE TABLE t (v INTEGER)");
    db.execute("INSERT INTO t VALUES (1)");
    db.execute("PRAGMA synchronous = NORMAL");
    db.execute("INSERT INTO t VALUES (2)");
    disk.write_survivors(after / "", {.survivors = Survivors::none, .seed = 0});
  }
  storage::Database db(after / "lazy.db", SQLITE_OPEN_READWRITE, "");
  storage::Query rows(db, "SELECT count(*), max(v) FROM t");
  ASSERT_TRUE(rows.row());
  EXPECT_EQ(rows.integer(0), 1);
  EXPECT_EQ(rows.integer(1), 1);
}

}  // namespace
}  // namespace driftwise::faults
