#include "server/application/upkeep/cell_clock.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>

#include "server/application/plumbing/signal.h"
#include "server/application/upkeep/wall_clock_watch.h"

namespace driftwise::application {
namespace {

class CellClockTest : public testing::Test {
 protected:
  CellClockTest()
      : path_((std::filesystem::temp_directory_path() /
               ("driftwise-clock-" + std::to_string(::getpid())))
                  .string()) {}
  ~CellClockTest() override { std::filesystem::remove(path_); }
  std::unique_ptr<CellClock> open(double speed) {
    ClockDescription d;
    d.speed = speed;
    d.file = path_;
    auto clock = CellClock::open(io_.get_executor(), d, computer_);
    if (!clock) throw std::runtime_error(clock.error().message);
    return std::move(*clock);
  }
  // Writes the file byte by byte, as another program would by the contract.
  void write_file(std::int64_t boot_ns, std::int64_t cell_ns, double speed,
                  const char* magic = "DWCLOCK2") {
    std::uint64_t sequence = 2;
    char bytes[64] = {};
    std::memcpy(bytes, magic, 8);
    std::memcpy(bytes + 8, &sequence, 8);
    std::memcpy(bytes + 16, &boot_ns, 8);
    std::memcpy(bytes + 24, &cell_ns, 8);
    std::memcpy(bytes + 32, &speed, 8);
    for (int i = 0; i < 16; ++i)
      bytes[48 + i] = static_cast<char>(std::stoi(kBoot.substr(2 * i, 2), nullptr, 16));
    std::ofstream(path_, std::ios::binary).write(bytes, sizeof bytes);
  }
  double file_speed() const {
    char bytes[64];
    std::ifstream(path_, std::ios::binary).read(bytes, sizeof bytes);
    double speed;
    std::memcpy(&speed, bytes + 32, 8);
    return speed;
  }
  std::int64_t boot_ns() const { return computer_.boot_ns(); }
  const std::string kBoot = "0123456789abcdef0123456789abcdef";
  ComputerClock computer_ = [this] {
    auto computer = this_computer();
    computer.boot = kBoot;
    return computer;
  }();
  asio::io_context io_;
  std::string path_;
};

TEST_F(CellClockTest, WithoutAFileIsUtc) {
  const auto clock = CellClock::open(io_.get_executor(), {}, computer_);
  ASSERT_TRUE(clock);
  EXPECT_LT(std::abs((*clock)->now().utc.utc_ns - computer_.wall_ns()), 1'000'000'000);
  EXPECT_EQ((*clock)->speed(), 1.0);
}

TEST_F(CellClockTest, RunsFromTheAnchorAtTheSpeedOfTheFile) {
  constexpr std::int64_t kCell = 1'000'000'000'000'000;
  const auto anchor = boot_ns();
  write_file(anchor, kCell, 100);
  const auto clock = open(100);
  const auto before = boot_ns();
  const auto now = clock->now().utc.utc_ns;
  const auto after = boot_ns();
  EXPECT_GE(now, kCell + (before - anchor) * 100);
  EXPECT_LE(now, kCell + (after - anchor) * 100);
}

TEST_F(CellClockTest, RefusesADamagedFile) {
  write_file(0, 0, 100, "NOTCLOCK");
  ClockDescription d{{}, 100, path_};
  EXPECT_EQ(CellClock::open(io_.get_executor(), d, computer_).error().reason, "BAD_CLOCK_FILE");
  write_file(0, 0, -1);
  EXPECT_EQ(CellClock::open(io_.get_executor(), d, computer_).error().reason, "BAD_CLOCK_FILE");
  std::ofstream(path_) << "short";
  EXPECT_EQ(CellClock::open(io_.get_executor(), d, computer_).error().reason, "BAD_CLOCK_FILE");
  std::filesystem::remove(path_);
  EXPECT_EQ(CellClock::open(io_.get_executor(), d, computer_).error().reason, "NO_CLOCK_FILE");
}

TEST_F(CellClockTest, SleepsInCellTimeAndNeverWakesEarly) {
  write_file(boot_ns(), 0, 1000);
  auto clock = open(1000);
  const auto due = clock->now().utc + std::chrono::seconds(5);  // 5 ms of wall time
  CellTime woke;
  asio::co_spawn(io_, clock->sleep_until(due),
                 [&](std::exception_ptr) { woke = clock->now().utc; });
  io_.run();
  EXPECT_GE(woke, due);
}

TEST_F(CellClockTest, GivesWayWithoutAJumpAndWritesTheFile) {
  write_file(boot_ns(), 0, 1000);
  auto clock = open(1000);
  const auto before = clock->now();
  clock->report_lag(std::chrono::seconds(2));
  const auto after = clock->now();
  EXPECT_EQ(clock->speed(), 500);
  EXPECT_EQ(file_speed(), 500);
  EXPECT_GE(after.utc, before.utc);
  EXPECT_GE(after.monotonic_ns, before.monotonic_ns);
}

TEST_F(CellClockTest, ArmsSleepersAgainWhenTheSpeedChanges) {
  write_file(boot_ns(), 0, 1000);
  auto clock = open(1000);
  const auto due = clock->now().utc + std::chrono::seconds(10);
  CellTime woke;
  asio::co_spawn(io_, clock->sleep_until(due),
                 [&](std::exception_ptr) { woke = clock->now().utc; });
  io_.poll();
  clock->report_lag(std::chrono::seconds(2));
  io_.run();
  EXPECT_GE(woke, due);  // the old timer would have woken it after half of the cell time
}

TEST_F(CellClockTest, ASignalEndsASleep) {
  write_file(boot_ns(), 0, 2);
  auto clock = open(2);
  Signal signal(io_.get_executor());
  bool woke = false;
  asio::co_spawn(io_, sleep_unless(*clock, clock->now().utc + std::chrono::hours(10), signal),
                 [&](std::exception_ptr) { woke = true; });
  io_.poll();
  EXPECT_FALSE(woke);
  signal.raise();
  io_.run();
  EXPECT_TRUE(woke);
}

TEST_F(CellClockTest, KeepsTheFloorOfTimeouts) {
  write_file(boot_ns(), 0, 200);
  const auto clock = open(200);
  using std::chrono::milliseconds;
  EXPECT_EQ(clock->wall_from(std::chrono::seconds(1), milliseconds(250)), milliseconds(250));
  EXPECT_EQ(clock->wall_from(std::chrono::seconds(100), milliseconds(250)), milliseconds(500));
}

TEST_F(CellClockTest, RefusesAFileOfAnEarlierStartOfTheComputer) {
  write_file(boot_ns(), 0, 100);
  computer_.boot = "ff" + kBoot.substr(2);
  ClockDescription d{{}, 100, path_};
  EXPECT_EQ(CellClock::open(io_.get_executor(), d, computer_).error().reason, "OLD_CLOCK_FILE");
}

// Issue 11, number 12: somebody sets the wall clock.
class SetWallClock : public CellClockTest {
 protected:
  SetWallClock() {
    computer_.boot_ns = [this] { return boot_ns_; };
    computer_.wall_ns = [this] { return kUtc_ns + boot_ns_ + set_ns_; };
  }
  static constexpr std::int64_t kUtc_ns = 1'795'000'000'000'000'000;
  std::int64_t boot_ns_ = 5'000'000'000, set_ns_ = 0;
};

TEST_F(SetWallClock, ChangesUtcAndNotCellTime) {
  const auto clock = *CellClock::open(io_.get_executor(), {}, computer_);
  const auto before = clock->now();
  for (const std::int64_t step_s : {-600, 3600}) {
    set_ns_ += step_s * 1'000'000'000;
    boot_ns_ += 1'000'000'000;
  }
  EXPECT_EQ(seconds_from(clock->now().utc - before.utc), 2);
  EXPECT_EQ(clock->now().monotonic_ns - before.monotonic_ns, 2'000'000'000);
  EXPECT_EQ(clock->wall_ahead_ns(), kUtc_ns + 3000 * 1'000'000'000LL);
}

TEST_F(SetWallClock, ASuspendIsTimeThatHasPassed) {
  auto clock = std::move(*CellClock::open(io_.get_executor(), {}, computer_));
  bool woke = false;
  asio::co_spawn(io_, clock->sleep_for(std::chrono::hours(1)),
                 [&](std::exception_ptr) { woke = true; });
  io_.poll();
  boot_ns_ += 3600 * 1'000'000'000LL;  // the computer slept, and its timers with it
  io_.run_for(std::chrono::seconds(5));
  EXPECT_TRUE(woke);
}

TEST_F(SetWallClock, CellTimeGoesOnBehindTheRecordAndAcrossARestart) {
  ClockRecord first;
  {
    const auto clock = *CellClock::open(io_.get_executor(), {}, computer_);
    first = begin_cell_time(*clock, {}, {}).records.back();
    EXPECT_EQ(first.offset.count(), 0);
  }
  boot_ns_ += 60'000'000'000;
  set_ns_ = -600'000'000'000;
  {
    const auto clock = *CellClock::open(io_.get_executor(), {}, computer_);
    const auto start = begin_cell_time(*clock, {first}, first.from);
    const auto& again = start.records.back();
    EXPECT_EQ(again.from - first.from, std::chrono::seconds(60)) << "as the monotonic clock has it";
    EXPECT_EQ(again.step, std::chrono::seconds(-600));
    EXPECT_EQ(clock->utc(clock->now().utc).ns, kUtc_ns + boot_ns_ + set_ns_);
    EXPECT_EQ(clock->utc(first.from).ns, first.from.utc_ns) << "what was before keeps its UTC";
  }
  // A new start of the computer, with the clock wrong.
  computer_.boot = "ff" + kBoot.substr(2);
  const auto clock = *CellClock::open(io_.get_executor(), {}, computer_);
  const auto start = begin_cell_time(*clock, {first}, first.from + std::chrono::seconds(60));
  EXPECT_GT(start.records.back().from, first.from + std::chrono::seconds(60));
  EXPECT_EQ(clock->utc(clock->now().utc).ns, kUtc_ns + boot_ns_ + set_ns_);
}

}  // namespace
}  // namespace driftwise::application
