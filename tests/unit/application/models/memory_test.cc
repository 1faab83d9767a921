// Readings that a model's effects with memory are brought up to date by.

#include "server/application/serving/memory.h"

#include <gtest/gtest.h>

#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

using application::readings_for_memory;

CellTime world_s(double s) { return kWorldBegin + nanoseconds_from_s(s); }

class MemoryOfAModel : public testing::Test {
 protected:
  MemoryOfAModel() {
    cell.devices[1].channels = {{"t01", "degC"}, {"t02", "degC"}};
    cell.devices[2].channels = {{"x", "mm"}};
  }
  void record(const std::string& device, const std::string& channel, int count, double every_s) {
    std::vector<Reading> readings;
    for (int i = 0; i < count; ++i) {
      const auto at = world_s(i * every_s);
      readings.push_back({device, at, at, i, {{channel, 20 + 1e-5 * i}}});
    }
    ASSERT_TRUE(store->readings().append(readings, {}));
  }
  std::vector<Reading> read(const std::vector<std::string>& channels, double now_s) {
    return read_for(application::MemoryQuery{channels}, now_s);
  }
  std::vector<Reading> read_for(const application::MemoryQuery& query, double now_s) {
    return *readings_for_memory(*store, cell, query, world_s(now_s));
  }

  Folder folder;
  CellDescription cell = small_cell(folder / "cell.sqlite");
  std::unique_ptr<Store> store = *kSqlite(folder / "cell.sqlite", false);
};

TEST_F(MemoryOfAModel, IsOfTheDevicesThatGiveItsChannelsAlone) {
  record("scanner", "t01_degC", 10, 10);
  record("laser-x", "x_mm", 40, 2);
  const auto found = read({"t01_degC", "t02_degC"}, 100);
  ASSERT_EQ(found.size(), 10U) << "each device once";
  for (const auto& reading : found) EXPECT_EQ(reading.device, "scanner");
  EXPECT_TRUE(read({}, 100).empty());
}

TEST_F(MemoryOfAModel, IsOfEveryDeviceWhereTheCellFileNamesNoneForAChannel) {
  record("scanner", "t01_degC", 10, 10);
  record("laser-x", "air_degC", 40, 2);
  const auto found = read({"t01_degC", "air_degC"}, 100);
  ASSERT_EQ(found.size(), 50U);
  for (std::size_t i = 1; i < found.size(); ++i) EXPECT_LE(found[i - 1].start, found[i].start);
}

TEST_F(MemoryOfAModel, ReachesBackSixHours) {
  record("scanner", "t01_degC", 9, 3600);
  EXPECT_EQ(read({"t01_degC"}, 8 * 3600 + 1).size(), 6U);
}

TEST_F(MemoryOfAModel, KeepsTheNewestOfADeviceThatIsReadVeryOften) {
  constexpr int kReadings = application::kMemoryReadings + 100;
  record("scanner", "t01_degC", kReadings, 0.25);
  const auto found = read({"t01_degC"}, kReadings * 0.25);
  ASSERT_EQ(found.size(), static_cast<std::size_t>(application::kMemoryReadings));
  EXPECT_EQ(found.front().sequence, 100);
  EXPECT_EQ(found.back().sequence, kReadings - 1);
}

TEST_F(MemoryOfAModel, OfAChannelThatWasNeverRecordedIsNone) {
  EXPECT_TRUE(read_for({{"t01_degC"}, std::chrono::hours(30), {}}, 40 * 3600).empty());
}

// What a replay does, one letter each: a reading, the anchor.
struct Seen {
  std::string order;
  void observe(const Reading&) { order += 'r'; }
};

TEST(Replay, AnchorsAfterTheReadingsUpToTheZero) {
  std::vector<Reading> readings;
  for (int i = 0; i < 4; ++i) readings.push_back({"scanner", world_s(i), world_s(i), i, {}});
  const auto order = [&](std::optional<CellTime> zero) {
    Seen seen;
    application::replay(readings, zero, seen, [&] { seen.order += 'A'; });
    return seen.order;
  };
  EXPECT_EQ(order(world_s(1)), "rrArr");
  EXPECT_EQ(order(world_s(-1)), "Arrrr");
  EXPECT_EQ(order(world_s(9)), "rrrrA");
  EXPECT_EQ(order({}), "rrrrA");
}

}  // namespace
}  // namespace driftwise::tests
