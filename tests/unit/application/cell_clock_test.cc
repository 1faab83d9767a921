#include "server/application/cell_clock.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "server/application/signal.h"

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
    auto clock = CellClock::open(io_.get_executor(), d);
    if (!clock) throw std::runtime_error(clock.error().message);
    return std::move(*clock);
  }
  // Writes the file byte by byte, as another program would by the contract.
  void write_file(std::int64_t wall_ns, std::int64_t cell_ns, double speed,
                  const char* magic = "DWCLOCK1") {
    std::uint64_t sequence = 2;
    char bytes[40];
    std::memcpy(bytes, magic, 8);
    std::memcpy(bytes + 8, &sequence, 8);
    std::memcpy(bytes + 16, &wall_ns, 8);
    std::memcpy(bytes + 24, &cell_ns, 8);
    std::memcpy(bytes + 32, &speed, 8);
    std::ofstream(path_, std::ios::binary).write(bytes, sizeof bytes);
  }
  double file_speed() const {
    char bytes[40];
    std::ifstream(path_, std::ios::binary).read(bytes, sizeof bytes);
    double speed;
    std::memcpy(&speed, bytes + 32, 8);
    return speed;
  }
  static std::int64_t wall_ns() {
    return std::chrono::system_clock::now().time_since_epoch().count();
  }
  asio::io_context io_;
  std::string path_;
};

TEST_F(CellClockTest, WithoutAFileIsUtc) {
  const auto clock = CellClock::open(io_.get_executor(), {});
  ASSERT_TRUE(clock);
  EXPECT_LT(std::abs((*clock)->now().utc.utc_ns - wall_ns()), 1'000'000'000);
  EXPECT_EQ((*clock)->speed(), 1.0);
}

TEST_F(CellClockTest, RunsFromTheAnchorAtTheSpeedOfTheFile) {
  constexpr std::int64_t kCell = 1'000'000'000'000'000;
  const auto anchor = wall_ns();
  write_file(anchor, kCell, 100);
  const auto clock = open(100);
  const auto before = wall_ns();
  const auto now = clock->now().utc.utc_ns;
  const auto after = wall_ns();
  EXPECT_GE(now, kCell + (before - anchor) * 100);
  EXPECT_LE(now, kCell + (after - anchor) * 100);
}

TEST_F(CellClockTest, RefusesADamagedFile) {
  write_file(0, 0, 100, "NOTCLOCK");
  ClockDescription d{{}, 100, path_};
  EXPECT_EQ(CellClock::open(io_.get_executor(), d).error().reason, "BAD_CLOCK_FILE");
  write_file(0, 0, -1);
  EXPECT_EQ(CellClock::open(io_.get_executor(), d).error().reason, "BAD_CLOCK_FILE");
  std::ofstream(path_) << "short";
  EXPECT_EQ(CellClock::open(io_.get_executor(), d).error().reason, "BAD_CLOCK_FILE");
  std::filesystem::remove(path_);
  EXPECT_EQ(CellClock::open(io_.get_executor(), d).error().reason, "NO_CLOCK_FILE");
}

TEST_F(CellClockTest, SleepsInCellTimeAndNeverWakesEarly) {
  write_file(wall_ns(), 0, 1000);
  auto clock = open(1000);
  const auto due = clock->now().utc + std::chrono::seconds(5);  // 5 ms of wall time
  CellTime woke;
  asio::co_spawn(io_, clock->sleep_until(due),
                 [&](std::exception_ptr) { woke = clock->now().utc; });
  io_.run();
  EXPECT_GE(woke, due);
}

TEST_F(CellClockTest, GivesWayWithoutAJumpAndWritesTheFile) {
  write_file(wall_ns(), 0, 1000);
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
  write_file(wall_ns(), 0, 1000);
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
  write_file(wall_ns(), 0, 2);
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
  write_file(wall_ns(), 0, 200);
  const auto clock = open(200);
  using std::chrono::milliseconds;
  EXPECT_EQ(clock->wall_from(std::chrono::seconds(1), milliseconds(250)), milliseconds(250));
  EXPECT_EQ(clock->wall_from(std::chrono::seconds(100), milliseconds(250)), milliseconds(500));
}

}  // namespace
}  // namespace driftwise::application
