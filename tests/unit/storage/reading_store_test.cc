#include <limits>

#include "tests/unit/storage/store_fixture.h"

namespace driftwise::storage {
namespace {

using ReadingStoreTest = StoreTest;

std::string text_of(const std::string& path, const char* sql) {
  Database db(path, SQLITE_OPEN_READONLY, "");
  Query query(db, sql);
  return query.row() ? query.text(0) : "";
}

Reading scan(double seconds, std::int64_t sequence, double degc = 20.5) {
  return {"scanner",
          at_s(seconds).utc,
          at_s(seconds + 0.8).utc,
          sequence,
          {{"t01_degC", degc}, {"t02_degC", kMissing}}};
}

TEST_F(ReadingStoreTest, KeepsAReadingWhole) {
  ASSERT_TRUE(store->readings().append(std::vector{scan(1, 42, 20.000000000000004)}, {}));
  reopen();
  const auto found = store->readings().readings("scanner", at_s(0).utc, at_s(2).utc, 0).value();
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].device, "scanner");
  EXPECT_EQ(found[0].start, at_s(1).utc);
  EXPECT_EQ(found[0].end, at_s(1.8).utc);
  EXPECT_EQ(found[0].sequence, 42);
  EXPECT_EQ(value_of(found[0].values, "t01_degC"), 20.000000000000004);
  EXPECT_TRUE(is_missing(
      value_of(found[0].values, "t02_degC")));  // asked for, no value: not the same as not asked
  EXPECT_EQ(found[0].find("t03_degC"), nullptr);
}

TEST_F(ReadingStoreTest, KeepsARejectedValueAsItWasGivenSaysWhyAndGivesItToNobody) {
  const double inf = std::numeric_limits<double>::infinity();
  const Reading reading{
      "support", at_s(1).utc, at_s(2).utc, 7, {{"support_degC", inf}, {"support_power_pct", 40}}};
  const RejectedAnswer rejected{
      "support", reading.start, 7, {"support_degC", "not_finite", "support_degC is inf"}};
  ASSERT_TRUE(store->readings().append(std::vector{reading}, {}, std::vector{rejected}));
  const auto kept = store->readings().readings("support", at_s(0).utc, at_s(9).utc, 0);
  ASSERT_TRUE(kept);
  ASSERT_EQ(kept->size(), 1U);
  EXPECT_TRUE(is_missing(value_of((*kept)[0].values, "support_degC")));
  EXPECT_EQ(value_of((*kept)[0].values, "support_power_pct"), 40);
  EXPECT_EQ(
      text_of(path, "SELECT test || ': ' || reason FROM rejected_reading WHERE value > 1e308"),
      "not_finite: support_degC is inf");
}

TEST_F(ReadingStoreTest, TakesFromAndLeavesTo) {
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(store->readings().append(std::vector{scan(i, i)}, {}));
  const auto found = store->readings().readings("scanner", at_s(1).utc, at_s(3).utc, 0).value();
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].sequence, 1);
  EXPECT_EQ(found[1].sequence, 2);
  EXPECT_TRUE(store->readings().readings("laser-y", at_s(0).utc, at_s(9).utc, 0)->empty());
}

TEST_F(ReadingStoreTest, MergesAllDevicesInTimeAndGivesTheNewestWithinTheLimit) {
  std::vector<Reading> readings;
  for (int i = 0; i < 6; ++i) {
    readings.push_back(scan(2 * i, i));
    readings.push_back(
        {"support", at_s(2 * i + 1).utc, at_s(2 * i + 1).utc, i, {{"support_degC", 20.0}}});
  }
  std::reverse(readings.begin(), readings.end());  // stored late, as after a waiting commit
  ASSERT_TRUE(store->readings().append(readings, {}));
  const auto found = store->readings().readings("", at_s(0).utc, at_s(99).utc, 7).value();
  ASSERT_EQ(found.size(), 7u);
  for (std::size_t i = 0; i < found.size(); ++i)
    EXPECT_EQ(found[i].start, at_s(static_cast<double>(i + 5)).utc);
  const auto last = store->readings().readings("scanner", at_s(0).utc, at_s(99).utc, 2).value();
  ASSERT_EQ(last.size(), 2u);
  EXPECT_EQ(last[0].sequence, 4);
  EXPECT_EQ(last[1].sequence, 5);
}

TEST_F(ReadingStoreTest, KeepsTwoReadingsOfOneInstant) {
  ASSERT_TRUE(store->readings().append(std::vector{scan(1, 0), scan(1, 0)}, {}));
  EXPECT_EQ(store->readings().readings("scanner", at_s(0).utc, at_s(9).utc, 0)->size(), 2u);
}

TEST_F(ReadingStoreTest, KeepsMovesOfManyAxesInOrder) {
  const std::vector<MoveRecord> moves = {{run, at_s(2), {1, 2, 3}, {4, 5, 6}, "point"},
                                         {std::nullopt, at_s(2), {}, {-0.0, 7}, "operator"},
                                         {std::nullopt, at_s(1), {}, {}, "homing"}};
  ASSERT_TRUE(store->readings().append({}, moves));
  const auto found = store->readings().moves(at_s(0).utc, at_s(9).utc).value();
  ASSERT_EQ(found.size(), 3u);
  EXPECT_EQ(found[0].cause, "homing");
  EXPECT_TRUE(found[0].to_mm.empty());
  EXPECT_EQ(found[1].run, run);
  EXPECT_EQ(found[1].from_mm, moves[0].from_mm);
  EXPECT_EQ(found[1].to_mm, moves[0].to_mm);
  EXPECT_EQ(found[1].at.monotonic_ns, at_s(2).monotonic_ns);
  EXPECT_TRUE(found[2].from_mm.empty());
  EXPECT_TRUE(std::signbit(found[2].to_mm.at(0)));
  EXPECT_EQ(found[2].to_mm.at(1), 7.0);
}

}  // namespace
}  // namespace driftwise::storage
