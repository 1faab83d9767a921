#include "server/compensation/snapshot_board.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

namespace driftwise::compensation {
namespace {

// A snapshot whose every number is its generation: a torn one shows.
Snapshot numbered(std::int64_t number) {
  Snapshot snapshot;
  snapshot.model = ModelId{number};
  snapshot.outputs.resize(2);
  for (auto& output : snapshot.outputs)
    output.coefficients_mm.assign(20, static_cast<double>(number));
  return snapshot;
}

TEST(SnapshotBoard, IsEmptyUntilTheFirstPublication) {
  SnapshotBoard board;
  EXPECT_FALSE(board.read());
  EXPECT_EQ(board.generation(), 0u);
  ASSERT_TRUE(board.publish(numbered(1)));
  ASSERT_TRUE(board.read());
  EXPECT_EQ(board.read()->model, ModelId{1});
  EXPECT_EQ(board.generation(), 1u);
}

TEST(SnapshotBoard, KeepsASnapshotInPlaceWhileItIsRead) {
  SnapshotBoard board;
  ASSERT_TRUE(board.publish(numbered(1)));
  const auto read = board.read();
  for (int i = 2; i < 100; ++i) ASSERT_TRUE(board.publish(numbered(i)));
  EXPECT_EQ(read->model, ModelId{1});
  EXPECT_EQ(read->outputs[1].coefficients_mm[19], 1.0);
  EXPECT_EQ(board.read()->model, ModelId{99});
}

TEST(SnapshotBoard, SaysWhenReadersHoldEverySlotAndServesOn) {
  SnapshotBoard board;
  std::vector<SnapshotBoard::Read> held;
  int published = 0;
  while (board.publish(numbered(published + 1))) {
    ++published;
    held.push_back(board.read());
    ASSERT_LE(published, static_cast<int>(SnapshotBoard::kSlots));
  }
  EXPECT_EQ(published, static_cast<int>(SnapshotBoard::kSlots));
  EXPECT_EQ(board.read()->model, ModelId{published});  // the last one that could be published
  held.erase(held.begin());
  EXPECT_TRUE(board.publish(numbered(1000)));
  EXPECT_EQ(board.read()->model, ModelId{1000});
}

TEST(SnapshotBoard, ReleasesAReadThatWasMovedOnce) {
  SnapshotBoard board;
  ASSERT_TRUE(board.publish(numbered(1)));
  auto first = board.read();
  auto second = std::move(first);
  EXPECT_FALSE(
      first);  // NOLINT(bugprone-use-after-move): what a moved-from guard says is the point
  second = SnapshotBoard::Read();
  for (int i = 0; i < 64; ++i) ASSERT_TRUE(board.publish(numbered(i)));
}

// Run under tsan too. Readers look at every number of what they hold; generations never go back.
TEST(SnapshotBoard, NeverShowsATornOrOlderSnapshotToManyReaders) {
  SnapshotBoard board;
  std::atomic<bool> stop{false};
  std::atomic<int> torn{0}, backwards{0}, started{0};
  std::vector<std::thread> readers;
  for (int r = 0; r < 4; ++r)
    readers.emplace_back([&] {
      std::int64_t last = 0;
      ++started;
      while (!stop.load()) {
        const auto read = board.read();
        if (!read) continue;
        const auto number = read->model.value;
        for (const auto& output : read->outputs)
          for (const double value : output.coefficients_mm)
            torn += value != static_cast<double>(number);
        backwards += number < last;
        last = number;
      }
    });
  while (started.load() < 4) std::this_thread::yield();
  std::int64_t published = 0;
  for (int i = 1; i <= 20000; ++i) published += board.publish(numbered(i));
  stop = true;
  for (auto& reader : readers) reader.join();
  EXPECT_EQ(torn, 0);
  EXPECT_EQ(backwards, 0);
  EXPECT_GT(published, 10000);  // four readers can hold four of sixteen slots
}

}  // namespace
}  // namespace driftwise::compensation
