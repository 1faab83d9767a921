// Thinning: raw readings of the environment become one row per interval, and the chain says so.

#include <algorithm>
#include <limits>
#include <utility>

#include "storage/chain/thinned_entry.h"
#include "tests/unit/storage/store_fixture.h"

namespace driftwise::storage {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

constexpr double kFrom_s = 10'000;  // far from the fixture's datum

class ThinningTest : public StoreTest {
 protected:
  // A scan each second: 20 degC at first, a hundredth more in each; and a length beside it.
  void store_scans(int count, double from_s = kFrom_s) {
    std::vector<Reading> readings;
    for (int i = 0; i < count; ++i) {
      const auto from = at_s(from_s + i).utc, to = at_s(from_s + i + 0.5).utc;
      readings.push_back({"scanner", from, to, i, {{"t01_degC", 20 + 0.01 * i}}});
      readings.push_back({"laser-x", from, to, i, {{"x_mm", 1.0 * i}}});
    }
    ASSERT_TRUE(store->readings().append(readings, {}, {}));
    for (auto more = store->series().summarise(); more && *more;)
      more = store->series().summarise();
  }
  ThinningOrder order(const std::string& reducer = "mean") const {
    return {at_s(kFrom_s + 1e6).utc,
            10'000'000'000,
            reducer,
            at_s(2e6),
            {"ada", "token k3f9", "unix:"},
            0};
  }
  // Every step; what was done.
  ThinningStep thin(ThinningOrder wanted) {
    ThinningStep all;
    for (bool more = true; more;) {
      const auto step = store->audit().thin(wanted);
      EXPECT_TRUE(step) << step.error().message;
      if (!step) break;
      all.readings += step->readings;
      all.intervals += step->intervals;
      wanted.after_id = step->looked_id;
      more = step->more;
    }
    return all;
  }
  std::vector<Reading> scans() {
    return store->readings()
        .readings("scanner", at_s(kFrom_s).utc, at_s(kFrom_s + 1e6).utc, 0)
        .value();
  }
  ChainReport verified(const std::optional<ChainHead>& outside = {}) {
    return open_store(path, true)->audit().verify(outside, {}).value();
  }
  std::string first_found() {
    const auto report = verified();
    return report.first.empty() ? "nothing" : report.first.front();
  }
  void change(const std::string& sql) {
    store.reset();
    Database db(path, SQLITE_OPEN_READWRITE, "");
    db.execute("PRAGMA ignore_check_constraints = ON; PRAGMA foreign_keys = OFF; " + sql);
    store = open_store(path);
  }
};

TEST(ThinnedEntry, ReadsBackAsItIsWrittenAndNothingElse) {
  const std::vector<std::int64_t> readings{81, 83, 96};
  const std::string bytes = thinned_bytes(7, readings, std::string(32, 'h'));
  const auto entry = thinned_from(bytes);
  ASSERT_TRUE(entry);
  EXPECT_EQ(entry->thinning, 7);
  EXPECT_EQ(entry->count, 3);
  for (std::int64_t id = 70; id < 120; ++id)
    EXPECT_EQ(entry->holds(id), id == 81 || id == 83 || id == 96) << id;
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_FALSE(thinned_from(std::string_view(bytes).substr(0, size))) << size;
  EXPECT_FALSE(thinned_from(bytes + "x"));
  const std::vector<std::int64_t> beyond{std::numeric_limits<std::int64_t>::max()};
  EXPECT_FALSE(thinned_from(thinned_bytes(7, beyond, std::string(32, 'h'))));
}

TEST_F(ThinningTest, PutsOneRowInThePlaceOfAnInterval) {
  store_scans(100);
  const auto kept = store->audit().head().value();
  const auto done = thin(order());
  EXPECT_EQ(done.readings, 100);
  EXPECT_EQ(done.intervals, 10);
  const auto left = scans();
  ASSERT_EQ(left.size(), 10U);
  EXPECT_EQ(left[0].start, at_s(kFrom_s).utc);
  EXPECT_EQ(left[0].end, at_s(kFrom_s + 9.5).utc);
  EXPECT_NEAR(value_of(left[0].values, "t01_degC"), 20.045, 1e-9) << "the mean of ten";
  EXPECT_EQ(store->readings().readings("laser-x", at_s(0).utc, at_s(1e6).utc, 0)->size(), 100U)
      << "lengths stay";
  const auto report = verified(kept);
  EXPECT_TRUE(report.intact()) << report.first.front();
  EXPECT_EQ(report.thinned_readings, 100);
  ASSERT_EQ(report.thinned.size(), 1U);
  EXPECT_THAT(report.thinned[0], StartsWith("thinned: 100 readings of "));
  EXPECT_THAT(report.thinned[0], HasSubstr(" by ada at 2026-"));
  EXPECT_THAT(report.thinned[0], HasSubstr(", mean every 10 s, hash "));
}

TEST_F(ThinningTest, TakesTheReducerThatWasNamed) {
  store_scans(20);
  EXPECT_EQ(thin(order("max")).intervals, 2);
  EXPECT_NEAR(value_of(scans()[1].values, "t01_degC"), 20.19, 1e-9);
  store_scans(20, kFrom_s + 5000);
  EXPECT_EQ(thin(order("min")).intervals, 2);
  EXPECT_NEAR(value_of(scans()[3].values, "t01_degC"), 20.10, 1e-9);
  EXPECT_EQ(store->audit().thin(order("median")).error().reason, "BAD_REDUCER");
  auto too_long = order();
  too_long.every_ns *= 1000;
  EXPECT_EQ(store->audit().thin(too_long).error().reason, "BAD_RANGE");
}

TEST_F(ThinningTest, LeavesWhatAPointOrARejectedValueRefersTo) {
  ASSERT_TRUE(store->points().commit(example_commit(run, datum, 1000)));  // 14 010 s
  store_scans(1200, 13'500);
  const std::vector<Reading> doubted{
      {"scanner", at_s(20'000).utc, at_s(20'000.5).utc, 5, {{"t01_degC", 900}}},
      {"scanner", at_s(20'001).utc, at_s(20'001.5).utc, 6, {{"t01_degC", 20}}},
      {"scanner", at_s(20'002).utc, at_s(20'002.5).utc, 7, {{"t01_degC", 22}}}};
  ASSERT_TRUE(store->readings().append(
      doubted, {},
      std::vector{RejectedAnswer{"scanner", doubted[0].start, 5, {"t01_degC", "range", "900"}}}));
  store_scans(2, 30'000);
  thin(order());
  std::size_t near = 0, far = 0, rejected = 0;
  for (const auto& one : scans()) {
    const double at = seconds_from(one.start - CellTime{kStartNs});
    if (at > 13'712 && at < 14'310) ++near;
    if (at < 13'700) ++far;
    if (at == 20'000) ++rejected;
  }
  EXPECT_GE(near, 590U) << "raw, within five minutes of the attempt";
  EXPECT_EQ(far, 20U);
  EXPECT_EQ(rejected, 1U);
  EXPECT_EQ(first_found(), "nothing");
}

TEST_F(ThinningTest, CutsNoIntervalAtTheEndOfAStep) {
  store_scans(9000);
  const auto done = thin(order());
  EXPECT_EQ(done.readings, 9000);
  EXPECT_EQ(done.intervals, 900);
  EXPECT_EQ(first_found(), "nothing");
  EXPECT_GT(verified().thinned.size(), 2U) << "several transactions";
}

TEST_F(ThinningTest, ALaterPassLooksAtWhatIsNewOnly) {
  store_scans(20'000);
  store_scans(2000, kFrom_s + 50'000);
  auto wanted = order();
  wanted.before = at_s(kFrom_s + 40'000).utc;
  const auto pass = [&] {
    int steps = 0, readings = 0;
    for (bool more = true; more; ++steps) {
      const auto step = store->audit().thin(wanted).value();
      wanted.after_id = step.looked_id;
      readings += static_cast<int>(step.readings);
      more = step.more;
    }
    return std::pair(steps, readings);
  };
  const auto [first_steps, first_readings] = pass();
  EXPECT_GT(first_steps, 8);
  EXPECT_EQ(first_readings, 20'000);
  EXPECT_EQ(pass(), std::pair(1, 0)) << "nothing is older by now";
  wanted.before = at_s(kFrom_s + 60'000).utc;
  EXPECT_EQ(pass(), std::pair(1, 2000)) << "what was too new is not passed over";
  EXPECT_EQ(first_found(), "nothing");
}

TEST_F(ThinningTest, KeepsNothingForPointsThatWereMeasuredElsewhere) {
  NewRun imported = example_run("imported");
  imported.created = at_s(kFrom_s);
  imported.trajectory_name = imported.trajectory_text = "";
  Dataset file;
  file.rows = 1000;
  file.columns = {{Channel{"x", "mm"}, std::vector<double>(file.rows, 1.0)}};
  for (std::size_t row = 0; row < file.rows; ++row)
    file.time_s.push_back(1.0 * static_cast<double>(row));
  ASSERT_TRUE(store->runs().import_dataset(imported, file));
  store_scans(1000);
  EXPECT_EQ(thin(order()).readings, 1000);
}

TEST_F(ThinningTest, AnswersTheNewestRowsWhenFewAreAskedFor) {
  store_scans(3000);
  store_scans(20, kFrom_s + 100'000);
  auto wanted = order();
  wanted.before = at_s(kFrom_s + 90'000).utc;
  thin(wanted);
  const auto all = scans();
  ASSERT_EQ(all.size(), 320U);
  for (const int limit : {1, 10, 25, 319, 320, 1000}) {
    const auto some = store->readings()
                          .readings("scanner", at_s(kFrom_s).utc, at_s(kFrom_s + 1e6).utc, limit)
                          .value();
    const std::size_t count = std::min<std::size_t>(all.size(), static_cast<std::size_t>(limit));
    ASSERT_EQ(some.size(), count);
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_EQ(some[i].start, all[all.size() - count + i].start) << limit << ", " << i;
      EXPECT_EQ(value_of(some[i].values, "t01_degC"),
                value_of(all[all.size() - count + i].values, "t01_degC"))
          << limit << ", " << i;
    }
  }
}

TEST_F(ThinningTest, KeepsTheSeries) {
  store_scans(600);
  const auto minute = [this] {
    SeriesQuery asked;
    asked.channels = {"t01_degC"};
    asked.from = at_s(kFrom_s).utc;
    asked.to = at_s(kFrom_s + 600).utc;
    asked.buckets = 10;
    const auto answer = store->series().series(asked).value();
    std::vector<double> out;
    for (const double value : answer.columns.at(0).mean) out.push_back(value);
    return out;
  };
  const auto before = minute();
  thin(order());
  const auto after = minute();
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 1; i + 1 < after.size(); ++i) EXPECT_NEAR(after[i], before[i], 0.06) << i;
  change("DELETE FROM series_block; UPDATE series_mark SET reading_id = 0");
  for (auto more = store->series().summarise(); more && *more;) more = store->series().summarise();
  const auto made_again = minute();
  for (std::size_t i = 1; i + 1 < after.size(); ++i)
    EXPECT_NEAR(made_again[i], before[i], 0.06) << i;
}

TEST_F(ThinningTest, StillFindsAThinnedStretchThatWasAltered) {
  store_scans(100);
  thin(order());
  EXPECT_EQ(first_found(), "nothing");
  change(
      "UPDATE thinned_value SET value = value + 1e-9 WHERE start_ns = (SELECT min(start_ns) "
      "FROM thinned_value)");
  EXPECT_THAT(first_found(), StartsWith("thinned_value with thinning_id 1"));
  change(
      "UPDATE thinned_value SET value = value - 1e-9 WHERE start_ns = (SELECT min(start_ns) "
      "FROM thinned_value); UPDATE thinning SET hash = zeroblob(32)");
  EXPECT_THAT(first_found(), HasSubstr("thinning_id 1"));
}

TEST_F(ThinningTest, FindsAReadingThatWasPutBackOrRemovedBesides) {
  store_scans(100);
  thin(order());
  change(
      "INSERT INTO reading (reading_id, device_id, start_ns, end_ns, sequence) SELECT "
      "first_reading_id, 1, 5, 6, 7 FROM thinning");
  EXPECT_THAT(first_found(), HasSubstr("was removed by thinning 1 and is there again"));
  change("DELETE FROM reading WHERE reading_id = (SELECT first_reading_id FROM thinning)");
  EXPECT_EQ(first_found(), "nothing");
  change(
      "DELETE FROM reading_value WHERE reading_id = (SELECT first_reading_id + 1 FROM "
      "thinning); DELETE FROM reading WHERE reading_id = (SELECT first_reading_id + 1 FROM "
      "thinning)");
  EXPECT_THAT(first_found(), HasSubstr("is missing"));
}

// A value that is changed first and thinned then is still found: the chain has the digest of
// before.
TEST_F(ThinningTest, FindsAStretchThatWasAlteredBeforeItWasThinned) {
  store_scans(100);
  change(
      "UPDATE reading_value SET value = value + 1 WHERE reading_id = (SELECT min(reading_id) "
      "FROM reading WHERE start_ns > " +
      std::to_string(at_s(kFrom_s + 10).utc.utc_ns) + ")");
  thin(order());
  EXPECT_THAT(first_found(), HasSubstr("was changed before it was thinned"));
}

TEST_F(ThinningTest, IsJudgedTheSameByACheckerOfAnotherHand) {
  store_scans(100);
  thin(order());
  const auto says = [this] {
    const std::string command =
        "python3 " DRIFTWISE_SOURCE_DIR "/clients/examples/python/check_chain.py " + path;
    std::FILE* pipe = popen(command.c_str(), "r");
    std::string text;
    for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) text += static_cast<char>(c);
    pclose(pipe);
    return text;
  };
  EXPECT_THAT(says(), StartsWith("thinned: 100 readings of "));
  EXPECT_THAT(says(), HasSubstr("by ada"));
  EXPECT_THAT(says(), testing::EndsWith(to_string(verified().head) + "\n"));
}

TEST_F(ThinningTest, RefusesTheSameDeletionToAnybodyElse) {
  store_scans(20);
  change("CREATE TRIGGER worse AFTER INSERT ON event BEGIN DELETE FROM reading; END");
  const auto refused =
      store->events().add_event({{}, at_s(9), "ada", "", "note.added", "a remark", {}});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "ROWS_NEVER_CHANGE");
}

}  // namespace
}  // namespace driftwise::storage
