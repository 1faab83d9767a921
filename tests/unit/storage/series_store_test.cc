// Series by the pixel against a plain walk over the same values: nothing of their extremes, counts
// or means may be lost, whatever is summarised already and whatever is not.

#include <algorithm>
#include <numeric>
#include <random>

#include "tests/unit/storage/store_fixture.h"

namespace driftwise::storage {
namespace {

struct Plain {
  double min = kMissing, max = kMissing, sum = 0;
  std::int64_t count = 0;
};

class SeriesStoreTest : public StoreTest {
 protected:
  // Readings at uneven intervals, with a gap, some late, some values missing, some rejected.
  void fill(int readings, double interval_s) {
    std::mt19937_64 random(11);
    std::normal_distribution<double> noise(0, 1);
    double at = 0;
    std::vector<Reading> batch;
    std::vector<RejectedAnswer> rejected;
    for (int i = 0; i < readings; ++i) {
      at += interval_s * (0.5 + static_cast<double>(random() % 1000) / 1000);
      if (i == readings / 2) at += 5000;
      const double late_s = i % 17 == 0 ? -40 : 0;
      const double spike = i % 501 == 0 ? 50 : 0;
      const bool is_rejected = i % 97 == 5;
      const double usual = i % 13 == 0 ? kMissing : 20 + noise(random) + spike;
      const double value = is_rejected ? 1e308 : usual;
      const Stamp when = at_s(at + late_s);
      batch.push_back({"scanner", when.utc, when.utc, i, {{"t01_degC", value}, {"t02_degC", 1.0}}});
      if (is_rejected)
        rejected.push_back({"scanner", when.utc, i, {"t01_degC", "range", "t01_degC is 1e+308"}});
      else if (!is_missing(value))
        values_.emplace_back(when.utc.utc_ns / 1000 * 1000, value);
    }
    ASSERT_TRUE(store->readings().append(batch, {}, rejected));
    end_s_ = at;
  }

  void compare(double from_s, double to_s, int buckets) {
    SeriesQuery query;
    query.channels = {"t01_degC"};
    query.from = at_s(from_s).utc;
    query.to = at_s(to_s).utc;
    query.buckets = buckets;
    const auto answer = store->series().series(query);
    ASSERT_TRUE(answer) << answer.error().message;
    const auto& column = answer->columns.at(0);
    ASSERT_LE(answer->from, query.from);
    ASSERT_GE(answer->to, query.to);
    ASSERT_LE(column.count.size(), static_cast<std::size_t>(buckets) + 1);
    ASSERT_GE(column.count.size() * 5 / 4 + 2, static_cast<std::size_t>(std::min(buckets, 1000)));
    std::vector<Plain> plain(column.count.size());
    for (const auto& [at_ns, value] : values_) {
      if (at_ns < answer->from.utc_ns || at_ns >= answer->to.utc_ns) continue;
      auto& bucket =
          plain[static_cast<std::size_t>((at_ns - answer->from.utc_ns) / answer->bucket.count())];
      bucket.min = bucket.count == 0 ? value : std::min(bucket.min, value);
      bucket.max = bucket.count == 0 ? value : std::max(bucket.max, value);
      bucket.sum += value;
      ++bucket.count;
    }
    for (std::size_t i = 0; i < plain.size(); ++i) {
      ASSERT_EQ(column.count[i], plain[i].count) << "bucket " << i << " of " << plain.size();
      if (plain[i].count == 0) {
        ASSERT_TRUE(is_missing(column.min[i]) && is_missing(column.max[i]));
        continue;
      }
      ASSERT_EQ(column.min[i], plain[i].min) << "bucket " << i;
      ASSERT_EQ(column.max[i], plain[i].max) << "bucket " << i;
      ASSERT_NEAR(column.mean[i], plain[i].sum / static_cast<double>(plain[i].count), 1e-9);
    }
  }

  void compare_many_windows() {
    std::mt19937_64 random(3);
    for (int i = 0; i < 60; ++i) {
      const double from_s = static_cast<double>(random() % 1'000'000) / 1e6 * end_s_;
      const double length_s =
          1 + std::pow(static_cast<double>(random() % 1000) / 1000, 3) * end_s_ * 1.2;
      compare(from_s - 100, from_s - 100 + length_s, 1 + static_cast<int>(random() % 1500));
      if (HasFatalFailure()) return;
    }
    compare(-10, end_s_ + 10, 1);
    compare(-10, end_s_ + 10, 1600);
  }

  std::vector<std::pair<std::int64_t, double>> values_;
  double end_s_ = 0;
};

TEST_F(SeriesStoreTest, WithoutSummariesIsThatOfThePlainWalk) {
  fill(3000, 7);
  compare_many_windows();
}

TEST_F(SeriesStoreTest, WithSummariesIsThatOfThePlainWalk) {
  fill(12'000, 7);
  while (*store->series().summarise()) {
  }
  compare_many_windows();
}

TEST_F(SeriesStoreTest, HalfSummarisedIsThatOfThePlainWalk) {
  fill(9000, 40);
  ASSERT_TRUE(*store->series().summarise());
  compare_many_windows();
}

TEST_F(SeriesStoreTest, AQuickInstrumentIsSummarisedTheSame) {
  fill(10'000, 0.1);
  while (*store->series().summarise()) {
  }
  compare_many_windows();
}

TEST_F(SeriesStoreTest, SummariesSurviveAndGoOnAfterReopening) {
  fill(5000, 7);
  ASSERT_TRUE(*store->series().summarise());
  reopen();
  while (*store->series().summarise()) {
  }
  EXPECT_FALSE(*store->series().summarise());
  compare_many_windows();
}

TEST_F(SeriesStoreTest, IdleKeepsUpOnlyWhereItIsWorthIt) {
  fill(500, 7);
  ASSERT_TRUE(store->idle());
  EXPECT_TRUE(*store->series().summarise() == false);  // the step itself takes what there is
  compare_many_windows();
}

TEST_F(SeriesStoreTest, ARunsPointsAreASeriesToo) {
  for (int i = 0; i < 10; ++i) {
    PointCommit commit;
    commit.run = run;
    PointRecord accepted;
    accepted.run = run;
    accepted.datum = datum;
    accepted.row = i;
    accepted.measured = at_s(10.0 * i);
    accepted.values = {{"x_std_nm", 1.0 + i}};
    commit.point = accepted;
    ASSERT_TRUE(store->points().commit(commit));
  }
  SeriesQuery query{{"x_std_nm"}, at_s(0).utc, at_s(100).utc, 2, run};
  const auto answer = store->series().series(query).value();
  // Buckets lie on a grid of round instants, so there may be one more than was asked for.
  const auto& column = answer.columns[0];
  EXPECT_LE(column.count.size(), 3u);
  EXPECT_EQ(std::accumulate(column.count.begin(), column.count.end(), std::int64_t{0}), 10);
  EXPECT_EQ(*std::max_element(column.max.begin(), column.max.end()), 10);
  query.run = RunId{99};
  EXPECT_EQ(store->series().series(query).error().reason, "NO_SUCH_RUN");
}

// The longest range that a request may ask for: sums of its ends and a bucket pass 64 bits.
TEST_F(SeriesStoreTest, OfAllTimeHoldsEveryReading) {
  fill(3000, 7);
  for (const bool summarised : {false, true}) {
    if (summarised) {
      ASSERT_TRUE(store->series().summarise());
    }
    for (const int buckets : {1, 2, 7}) {
      SCOPED_TRACE(buckets);
      SeriesQuery query{{"t01_degC"}, {1}, {9'000'000'000'999'999'999}, buckets, {}};
      for (const CellTime from : {CellTime{1}, CellTime{-5}, at_s(-1).utc}) {
        query.from = from;
        const auto answer = store->series().series(query);
        ASSERT_TRUE(answer) << answer.error().message;
        EXPECT_GE(answer->to, query.to);
        const auto& count = answer->columns.at(0).count;
        EXPECT_LE(count.size(), static_cast<std::size_t>(buckets) + 1);
        EXPECT_EQ(std::accumulate(count.begin(), count.end(), std::int64_t{0}),
                  std::ssize(values_));
      }
    }
  }
}

TEST_F(SeriesStoreTest, AnswersForAChannelThatWasNeverRecordedWithAnEmptyColumn) {
  const auto answer = store->series().series({{"t99_degC"}, at_s(0).utc, at_s(9).utc, 4, {}});
  ASSERT_TRUE(answer) << answer.error().message;
  const auto& column = answer->columns.at(0);
  EXPECT_FALSE(column.recorded);
  EXPECT_GE(column.count.size(), 4U);
  EXPECT_EQ(std::accumulate(column.count.begin(), column.count.end(), std::int64_t{0}), 0);
}

}  // namespace
}  // namespace driftwise::storage
