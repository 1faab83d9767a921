// Somebody sets the wall clock of the computer while a run is under way, as both programs see it;
// and somebody sets that of the interferometer's adapter. Hours pass at once while no daemon runs.
// The computer's own clock is never touched.

#include <gmock/gmock.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <sstream>

#include "tests/integration/cell/cell_at_work.h"

namespace driftwise::tests {
namespace {

using testing::HasSubstr;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kCanPreload = false;
#else
constexpr bool kCanPreload = true;
#endif

// The file that the preloaded library reads.
class WallClockOfThePrograms {
 public:
  WallClockOfThePrograms() { set(0); }
  std::vector<std::string> environment() const {
    return {std::string("LD_PRELOAD=") + DRIFTWISE_SET_WALL_CLOCK,
            "DRIFTWISE_TEST_WALL_CLOCK=" + path()};
  }
  void set(std::int64_t ahead_s) const {
    const std::int64_t ns = ahead_s * 1'000'000'000;
    std::fstream file(path(), std::ios::in | std::ios::out | std::ios::binary);
    if (!file) file.open(path(), std::ios::out | std::ios::binary);
    file.write(reinterpret_cast<const char*>(&ns), sizeof ns);
  }

 private:
  std::string path() const { return folder_.path() + "/ahead"; }
  TemporaryFolder folder_;
};

std::vector<double> times_s(const std::string& csv) {
  std::vector<double> values;
  std::istringstream lines(csv);
  for (std::string line; std::getline(lines, line);)
    if (!line.empty() && std::isdigit(static_cast<unsigned char>(line[0])))
      values.push_back(std::stod(line));
  return values;
}

// "3 min 05 s"
std::string minutes_text(double seconds) {
  EXPECT_GE(seconds, 60);
  EXPECT_LT(seconds, 3600);
  const auto whole = std::llround(seconds);
  const auto rest = std::to_string(whole % 60);
  return std::to_string(whole / 60) + " min " + (rest.size() < 2 ? "0" : "") + rest + " s";
}

struct ClockSteps {
  const char* name;
  std::vector<int> ahead_s;  // one after another, each after some points
};
class WallClockOnTheWire : public testing::TestWithParam<ClockSteps> {};

TEST_P(WallClockOnTheWire, TheRunGoesOnAndSaysSo) {
  if (!kCanPreload) GTEST_SKIP() << "NOT TESTED: a sanitizer's library must be loaded first";
  const WallClockOfThePrograms wall_clock;
  CellAtWork cell({.environment = wall_clock.environment()});
  cell.start_daemon();
  const auto run = cell.start_run(campaign(3, 8));
  std::int64_t points = 4;
  for (const int ahead_s : GetParam().ahead_s) {
    cell.wait_for_points(points);
    const auto steps = cell.events("clock.stepped");
    wall_clock.set(ahead_s);
    wait_until("the step is on record", [&] { return cell.events("clock.stepped") > steps; });
    wait_until("UTC is mapped anew", [&] {
      return cell.count(
                 "SELECT round(offset_ns / 1e9) FROM clock ORDER BY clock_id DESC LIMIT 1") ==
             ahead_s;
    });
    points += 6;
  }
  const auto ended = cell.end_of(run);
  EXPECT_EQ(ended.at("state"), "done") << ended.dump() << cell.daemon_log();
  EXPECT_EQ(cell.count("SELECT count(*) FROM point"), 24);
  const auto steps = static_cast<std::int64_t>(GetParam().ahead_s.size());
  EXPECT_EQ(cell.events("clock.stepped"), steps);
  EXPECT_EQ(cell.count("SELECT count(*) FROM alarm WHERE kind = 'clock.stepped'"), steps);
  EXPECT_EQ(cell.count("SELECT count(*) FROM (SELECT at_ns < lag(at_ns) OVER (ORDER BY event_id) "
                       "AS back FROM event) WHERE back"),
            0)
      << "cell time never runs back";
  const auto time_s = times_s(cell.say({"data", "export", std::to_string(run)}));
  ASSERT_EQ(time_s.size(), 24u);
  EXPECT_TRUE(std::is_sorted(time_s.begin(), time_s.end()));

  const double lasted_s = std::stod(cell.sql("SELECT duration_s FROM run_overview"));
  EXPECT_GT(lasted_s, time_s.back() - time_s.front()) << "the points are within";
  EXPECT_NEAR(ended.at("elapsed_s").get<double>(), lasted_s, 1e-6);
  EXPECT_THAT(cell.say({"run", "list"}), HasSubstr(" " + minutes_text(lasted_s) + " "));
  EXPECT_THAT(cell.say({"run", "show", std::to_string(run)}),
              HasSubstr(", after " + minutes_text(lasted_s) + "\n"));
}

INSTANTIATE_TEST_SUITE_P(Steps, WallClockOnTheWire,
                         testing::Values(ClockSteps{"TenMinutesBack", {-600}},
                                         ClockSteps{"OneHourBack", {-3600}},
                                         ClockSteps{"OneHourForward", {3600}},
                                         ClockSteps{"ForwardAndBack", {3600, -600}}),
                         [](const auto& row) { return std::string(row.param.name); });

TEST(AdaptersClockOnTheWire, AJumpRepeatsThePointAndAnHourIsAnAlarm) {
  CellAtWork cell;
  cell.start_daemon();
  const auto run = cell.start_run(campaign(3, 8));
  cell.wait_for_points(5);
  cell.control("fault clock laser-x 3600 s");
  const auto ended = cell.end_of(run);
  EXPECT_EQ(ended.at("state"), "done") << ended.dump() << cell.daemon_log();
  EXPECT_EQ(cell.count("SELECT count(*) FROM point"), 24);
  EXPECT_EQ(cell.count("SELECT count(*) FROM attempt WHERE verdict = 'interrupted'"), 1);
  wait_until("the jump is on record", [&] { return cell.events("device.clock_jumped") == 1; });
  EXPECT_THAT(cell.sql("SELECT detail FROM event WHERE what = 'device.clock_jumped'"),
              testing::AnyOf(HasSubstr("laser-x was set by +3599."),
                             HasSubstr("laser-x was set by +3600.")));
  wait_until("an alarm", [&] {
    return cell.count("SELECT count(*) FROM alarm WHERE kind = 'device.clock'") == 1;
  });
}

TEST(HoursThatPassAtOnce, AreRefusedUnderADaemonAndBehindItWhenItStartsAgain) {
  constexpr std::int64_t kNine_ns = 9 * 3600 * 1'000'000'000LL;
  CellAtWork cell;
  cell.start_daemon();
  const auto run = cell.start_run(campaign(1, 3));
  EXPECT_EQ(cell.end_of(run).at("state"), "done");
  EXPECT_THAT([&] { cell.control("pass 32400 s"); },
              testing::ThrowsMessage<std::runtime_error>(HasSubstr("end the daemon first")));
  EXPECT_EQ(cell.stop_daemon(), 0);
  const auto cell_time_ns = [&cell] { return std::stoll(cell.control("time?").substr(3)); };
  const auto before_ns = cell_time_ns();
  wait_until("the cell has seen the daemon's connections close", [&] {
    try {
      cell.control("pass 32400 s");
    } catch (const std::runtime_error&) {
      return false;
    }
    return true;
  });
  EXPECT_GE(cell_time_ns() - before_ns, kNine_ns);
  cell.start_daemon();
  const auto later = cell.start_run(campaign(1, 3));
  EXPECT_EQ(cell.end_of(later).at("state"), "done") << cell.daemon_log();
  EXPECT_GE(cell.count("SELECT max(measured_ns) - min(measured_ns) FROM point"), kNine_ns);
}

}  // namespace
}  // namespace driftwise::tests
