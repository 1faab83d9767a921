// The power fails under the whole application: recorder, engine, lease, serving over a disk that
// forgets unsynced writes. Virtual time, devices in memory. What a watcher had been told is there
// afterwards, once, and the run goes on to its end.

#include <gtest/gtest.h>
#include <spdlog/spdlog.h>

#include <map>
#include <random>

#include "storage/sqlite_store.h"
#include "tests/faults/unsynced_vfs.h"
#include "tests/support/cell_in_memory.h"

namespace driftwise::tests {
namespace {

using faults::PowerCut;
using faults::Survivors;
using faults::UnsyncedVfs;

const std::string kTrajectory = lines_of(3, {2, -3, 1, -1}, true);
constexpr std::int64_t kRows = 15;

OpenStore store_on(const std::string& vfs) {
  return [vfs](const std::string& path, bool read_only) {
    return storage::open_sqlite_store(path, read_only, {.vfs = vfs, .checkpoint_pages = 25});
  };
}

Result<RunRecord> ask_for_the_run(CellInMemory& cell) {
  application::CreateRun request;
  request.trajectory_text = kTrajectory;
  request.request_id = "the-one";
  return cell.try_run(request);
}

struct Told {
  bool run = false, done = false;
  std::int64_t accepted = 0;
};

// The daemon's life on this disk, until the run is over or the power is gone.
Told live(SmallWorld& world, const std::string& database, UnsyncedVfs& disk) {
  Told told;
  try {
    CellInMemory cell(world, small_cell(database), store_on(disk.name()));
    const auto watch = cell->runs.watch([&](const application::RunProgress& progress) {
      told.accepted = std::max(told.accepted, progress.run.accepted);
      told.done |= progress.run.state == RunState::done;
    });
    told.run = ask_for_the_run(cell).has_value();
    if (told.run) cell.until([&] { return disk.power_is_cut() || !cell.status().run; });
  } catch (const std::runtime_error&) {  // it could not even be opened
    EXPECT_TRUE(disk.power_is_cut());
  }
  return told;
}

// The daemon on what is left, an hour later, to the end of the run.
void judge(SmallWorld& world, const std::string& database, const Told& told) {
  const auto later = kWorldBegin + std::chrono::hours(1);
  {
    auto found = storage::open_sqlite_store(database, false);
    ASSERT_TRUE(found) << found.error().message;
    const auto runs = (*found)->runs().runs(10, 0).value();
    EXPECT_LE(runs.size(), 1u);
    EXPECT_TRUE(!told.run || runs.size() == 1) << "a run was acknowledged and is gone";
    if (told.done && !runs.empty()) {
      EXPECT_EQ(runs.front().state, RunState::done);
    }
  }
  CellInMemory cell(world, small_cell(database), store_on(""), later);
  const auto run = ask_for_the_run(cell);
  ASSERT_TRUE(run) << run.error().message;
  cell.until([&] { return !cell.status().run; });
  const auto ended = *cell.await(cell->runs.get(run->id));
  EXPECT_EQ(ended.state, RunState::done) << ended.reason;
  const auto points = *cell.await(cell.points(run->id, 0, 1000));
  std::map<std::int64_t, int> of_row;
  std::int64_t from_before = 0;
  for (const auto& point : points) {
    ++of_row[point.row];
    from_before += point.measured.utc < later;
  }
  EXPECT_EQ(static_cast<std::int64_t>(points.size()), kRows);
  EXPECT_EQ(static_cast<std::int64_t>(of_row.size()), kRows) << "lost or doubled";
  EXPECT_GE(from_before, told.accepted) << "an acknowledged point was lost and measured again";
  EXPECT_LE(from_before, told.accepted + 1) << "more than the commit under way";
}

std::int64_t changes_of_a_whole_life() {
  static const std::int64_t changes = [] {
    const Folder folder;
    SmallWorld world;
    UnsyncedVfs disk("whole-life");
    const auto told = live(world, folder / "cell.sqlite", disk);
    EXPECT_TRUE(told.done);
    EXPECT_EQ(told.accepted, kRows);
    return disk.changes();
  }();
  return changes;
}

// A daemon without a disk has much to say.
const bool kQuiet = (spdlog::set_level(spdlog::level::off), true);

void cut_and_judge(std::int64_t change, const PowerCut& cut) {
  SCOPED_TRACE("cut at change " + std::to_string(change) + " of " +
               std::to_string(changes_of_a_whole_life()) + ", survivors " +
               std::to_string(static_cast<int>(cut.survivors)) + ", seed " +
               std::to_string(cut.seed));
  const Folder before, after;
  SmallWorld world;
  Told told;
  {
    UnsyncedVfs disk("cell-cut");
    disk.cut_power_at(change);
    told = live(world, before / "cell.sqlite", disk);
    disk.write_survivors(after / "", cut);
  }
  judge(world, after / "cell.sqlite", told);
}

TEST(CellPowerCut, LosesNoAcknowledgedPointWhenNoUnsyncedWriteArrived) {
  std::mt19937_64 random(20110722);
  RecordProperty("faults", 40);
  for (int i = 0; i < 40 && !testing::Test::HasFailure(); ++i)
    cut_and_judge(static_cast<std::int64_t>(
                      1 + random() % static_cast<std::uint64_t>(changes_of_a_whole_life())),
                  {.survivors = Survivors::none, .seed = 0});
}

TEST(CellPowerCut, LosesNoAcknowledgedPointWhateverSectorsArrived) {
  std::mt19937_64 random(20261121);
  RecordProperty("faults", 40);
  for (int i = 0; i < 40 && !testing::Test::HasFailure(); ++i)
    cut_and_judge(static_cast<std::int64_t>(
                      1 + random() % static_cast<std::uint64_t>(changes_of_a_whole_life())),
                  {.survivors = Survivors::random, .seed = random()});
}

}  // namespace
}  // namespace driftwise::tests
