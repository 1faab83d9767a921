#include "storage/readings/kept_stretches.h"

#include <algorithm>
#include <random>

#include "tests/unit/storage/store_fixture.h"

namespace driftwise::storage {
namespace {

class KeptStretchesTest : public StoreTest {
 protected:
  // An attempt as the record has it, with times of its own.
  void add_attempt(double from_s, double to_s) {
    PointCommit commit;
    commit.run = run;
    commit.attempts.push_back({.row = row_++,
                               .number = 1,
                               .verdict = Verdict::reread,
                               .reason = "spread",
                               .started = at_s(from_s),
                               .ended = at_s(to_s),
                               .spread_nm = 1,
                               .readings = {}});
    ASSERT_TRUE(store->points().commit(commit));
    attempts_.emplace_back(at_s(from_s).utc.utc_ns, at_s(to_s).utc.utc_ns);
  }
  // By the rule itself: the reading is within five minutes of an attempt, or of the fixture's
  // datum.
  bool is_near(std::int64_t from_ns, std::int64_t to_ns) const {
    const auto near = [&](std::int64_t begin_ns, std::int64_t end_ns) {
      return from_ns <= end_ns + kAroundAttempt_ns && to_ns >= begin_ns - kAroundAttempt_ns;
    };
    const std::int64_t datum_ns = at_s(1).utc.utc_ns;
    return near(datum_ns, datum_ns) || std::ranges::any_of(attempts_, [&](const auto& one) {
             return near(one.first, one.second);
           });
  }
  void read_on() {
    Session session(path, SQLITE_OPEN_READONLY, "", true);
    kept.read_on(session);
    rows_looked_at = 0;
    for (sqlite3_stmt* one = sqlite3_next_stmt(session.db.handle(), nullptr); one != nullptr;
         one = sqlite3_next_stmt(session.db.handle(), one))
      rows_looked_at += sqlite3_stmt_status(one, SQLITE_STMTSTATUS_VM_STEP, 0);
  }

  KeptStretches kept;
  std::int64_t rows_looked_at = 0;  // in steps of SQLite's machine

 private:
  std::int64_t row_ = 0;
  std::vector<std::pair<std::int64_t, std::int64_t>> attempts_;
};

TEST_F(KeptStretchesTest, AreThoseAroundWhatWasMeasuredInWhateverOrderItCame) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> when(2'000, 200'000), length(0, 900);
  for (int i = 0; i < 120; ++i) {
    const double from = when(random);
    add_attempt(from, from + length(random));
    if (i % 40 == 39) read_on();
  }
  std::size_t within = 0;
  for (int i = 0; i < 4000; ++i) {
    const std::int64_t from = at_s(when(random)).utc.utc_ns, to = from + 500'000'000;
    EXPECT_EQ(kept.is_within(from, to), is_near(from, to)) << from;
    within += is_near(from, to);
  }
  EXPECT_GT(within, 500U);
  EXPECT_LT(within, 3500U);
}

TEST_F(KeptStretchesTest, ReadWhatIsNewAlone) {
  for (int i = 0; i < 300; ++i) add_attempt(1000.0 * i, 1000.0 * i + 1);
  read_on();
  const std::int64_t all = rows_looked_at;
  add_attempt(5e6, 5e6 + 1);
  read_on();
  EXPECT_LT(rows_looked_at, all / 10);
  EXPECT_TRUE(kept.is_within(at_s(5e6).utc.utc_ns, at_s(5e6).utc.utc_ns));
  EXPECT_TRUE(kept.is_within(at_s(7000).utc.utc_ns, at_s(7000).utc.utc_ns));
}

TEST_F(KeptStretchesTest, LeaveOutRowsThatWereMeasuredElsewhere) {
  Dataset file;
  file.rows = 2;
  file.time_s = {0, 1};
  file.columns.push_back({{"x", "mm"}, {0.5, 0.5}});
  NewRun imported = example_run("file");
  imported.created = at_s(50'000);
  ASSERT_TRUE(store->runs().import_dataset(imported, file));
  read_on();
  EXPECT_FALSE(kept.is_within(at_s(50'000).utc.utc_ns, at_s(50'001).utc.utc_ns));
}

}  // namespace
}  // namespace driftwise::storage
