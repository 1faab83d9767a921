// Texts that clients hand in are read beside the executor: as long as that takes, the cell lives.

#include <gtest/gtest.h>

#include <thread>

#include "server/application/alarms/alarm_conditions.h"
#include "server/application/plumbing/pause_meter.h"
#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

// The thread for texts does nothing until the test says so.
class TextsElsewhere : public testing::Test {
 protected:
  Folder folder;
  SmallWorld world;
  asio::io_context elsewhere;
  CellInMemory cell{world,
                    small_cell(folder / "cell.sqlite"),
                    kSqlite,
                    {.begin = kWorldBegin, .text_thread = elsewhere.get_executor()}};

  // The answer is not there before the text has been read, and a stop is, meanwhile.
  template <class T>
  T read_elsewhere(Awaitable<T> call) {
    std::optional<T> answer;
    cell.begin(std::move(call), answer);
    cell.pass(1);
    EXPECT_FALSE(answer.has_value()) << "read on the executor";
    EXPECT_TRUE(cell.await(cell->manual.stop_all(cell.ada)));
    cell.until([&] {
      elsewhere.restart();
      elsewhere.poll();
      return answer.has_value();
    });
    return std::move(*answer);
  }
};

const std::string kData = "time_s,q1_mm,x_mm\n1,0,0\n2,1,1.001\n3,2,2.001\n4,3,3.002\n";

TEST_F(TextsElsewhere, ADataset) {
  EXPECT_TRUE(read_elsewhere(cell->datasets.import_csv(cell.ada, "drift.csv", kData, "")));
}

TEST_F(TextsElsewhere, ADatasetOfAFit) {
  application::FitRequest request;
  request.csv = kData;
  request.formula = "q ~ x";
  EXPECT_TRUE(read_elsewhere(cell->models.check_formula(request)));
}

TEST_F(TextsElsewhere, ATrajectory) {
  EXPECT_TRUE(read_elsewhere(cell->trajectories.check("trajectory", lines_of(1, {1}, false))));
  EXPECT_TRUE(read_elsewhere(cell->trajectories.keep(cell.ada, "plan", lines_of(1, {1}, false))));
}

TEST_F(TextsElsewhere, TheTrajectoryOfARun) {
  application::CreateRun request;
  request.name = request.trajectory_name = "r";
  request.trajectory_text = lines_of(1, {1}, false);
  request.lease_token = cell.lease();
  const auto run = read_elsewhere(cell->runs.create(cell.ada, request));
  ASSERT_FALSE(run) << "a run that was asked for before the stop begins after it";
  EXPECT_EQ(run.error().reason, "STOPPED_MEANWHILE");
  EXPECT_EQ(world.moves, 0);
}

using Instant = application::PauseMeter::Instant;

TEST(PauseMeter, KeepsTheLongestPauseAndThatOfTheLastMinute) {
  asio::io_context context;
  application::PauseMeter meter(context.get_executor());
  const Instant begin{std::chrono::hours(1)};
  const auto pause = [&](int at_s, double pause_s) {
    const Instant due = begin + std::chrono::seconds(at_s);
    meter.note(due, due + std::chrono::milliseconds(static_cast<int>(pause_s * 1e3)));
  };
  pause(0, 0.001);
  pause(1, 2.5);
  pause(10, 0.8);
  pause(20, 0.2);
  EXPECT_DOUBLE_EQ(meter.longest_s(), 2.5);
  EXPECT_DOUBLE_EQ(meter.recent_s(begin + std::chrono::seconds(30)), 2.5);
  EXPECT_DOUBLE_EQ(meter.recent_s(begin + std::chrono::seconds(65)), 0.8) << "a minute later";
  EXPECT_DOUBLE_EQ(meter.recent_s(begin + std::chrono::seconds(75)), 0.2);
  EXPECT_DOUBLE_EQ(meter.recent_s(begin + std::chrono::seconds(200)), 0);
  EXPECT_DOUBLE_EQ(meter.longest_s(), 2.5);
}

TEST(PauseMeter, SeesAnExecutorThatIsBusy) {
  asio::io_context context;
  application::PauseMeter meter(context.get_executor());
  meter.start();
  context.run_for(std::chrono::milliseconds(120));
  std::this_thread::sleep_for(std::chrono::milliseconds(300));  // as a handler that takes so long
  context.run_for(std::chrono::milliseconds(60));
  EXPECT_GT(meter.longest_s(), 0.2);
  EXPECT_EQ(meter.longest_s(), meter.recent_s());
  meter.shut_down();
}

TEST(PauseMeter, MakesAnAlarm) {
  application::CellStatus status;
  status.recent_pause_s = 0.9;
  EXPECT_TRUE(application::alarm_conditions(status).empty());
  status.recent_pause_s = 27.8;
  const auto alarms = application::alarm_conditions(status);
  ASSERT_EQ(alarms.size(), 1U);
  EXPECT_EQ(alarms[0].kind, "daemon.paused");
  EXPECT_NE(alarms[0].message.find("27.8 s"), std::string::npos) << alarms[0].message;
}

}  // namespace
}  // namespace driftwise::tests
