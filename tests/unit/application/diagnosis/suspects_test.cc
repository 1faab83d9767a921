// Points that rest on a false instrument or zero: marked, kept out of fits, put back by a person.

#include "server/application/runs/suspects.h"

#include <gmock/gmock.h>

#include "server/application/alarms/alarms.h"
#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

TEST(SinceClosure, GivesThePointsSinceTheLastGoodOneOnce) {
  application::SinceClosure since;
  const auto at = [](double s) { return CellTime{} + nanoseconds_from_s(s); };
  since.add(0, at(0));
  since.add(1, at(10));
  since.close();
  since.add(3, at(20));
  since.add(2, at(30));
  EXPECT_THAT(since.take(at(100)), ElementsAre(2, 3));
  EXPECT_THAT(since.take(at(100)), ElementsAre());
  since.add(4, at(40));
  EXPECT_THAT(since.take(at(5)), ElementsAre(1, 4)) << "the instrument froze before the closure";
}

class FalseLength : public testing::Test {
 protected:
  std::int64_t count(const std::string& what) {
    return static_cast<std::int64_t>(cell.events_named(what).size());
  }
  void until_accepted(std::int64_t points) {
    cell.until([&] { return cell.status().run && cell.status().run->run.accepted >= points; });
  }
  std::vector<std::string> alarm_kinds() {
    std::vector<std::string> kinds;
    const auto alarms = cell.await(cell->alarms.list(true, 100));
    if (!alarms) throw std::runtime_error(alarms.error().message);
    for (const auto& alarm : *alarms) kinds.push_back(alarm.kind);
    return kinds;
  }
  static CellDescription described(const std::string& database) {
    auto cell = small_cell(database);
    auto& kinematics = cell.kinematics.emplace();
    kinematics.kind = "linear-axis";
    kinematics.axes.push_back({{"q1", "mm"}, {"x", "mm"}, 0, 0});
    return cell;
  }

  Folder folder;
  SmallWorld world;
  CellInMemory cell{world, described(folder / "cell.sqlite"), kSqlite};
};

// Lines of a return to zero and four points: rows 0 and 1..4, 5 and 6..9, ...
TEST_F(FalseLength, AJumpOfTenMicrometresMarksThePointsSinceTheLastGoodClosure) {
  const auto run = cell.begin_run(lines_of(5, {2, -3, 1, -1}, true)).id;
  until_accepted(8);
  world.zero_mm -= 0.010;
  EXPECT_EQ(cell.finish_run().state, RunState::done);
  const auto state = cell.await(cell->annotations.exclusions(run));
  ASSERT_TRUE(state);
  EXPECT_THAT(state->suspect_rows, ElementsAre(6, 7, 8, 9, 10));
  EXPECT_EQ(state->rows, state->suspect_rows);
  EXPECT_THAT(alarm_kinds(), testing::Contains("closure.bad"));
  EXPECT_EQ(count("datum.opened"), 2) << "what follows counts from a zero of its own";
  const auto csv = cell.await(cell->datasets.export_csv({run}, false));
  ASSERT_TRUE(csv);
  EXPECT_THAT(*csv, HasSubstr("excluded,suspect,"));
  const auto without = cell.await(cell->datasets.export_csv({run}, true));
  ASSERT_TRUE(without);
  EXPECT_THAT(*without, Not(HasSubstr("suspect")));

  ExclusionRecord back;
  back.run = run;
  back.excluded = false;
  back.rows = {6, 7};
  back.reason = "the jump came later";
  const auto after = cell.await(cell->annotations.exclude_rows(cell.ada, back));
  ASSERT_TRUE(after);
  EXPECT_THAT(after->suspect_rows, ElementsAre(8, 9, 10));
}

TEST_F(FalseLength, ALengthThatDoesNotFollowTheAxisIsNoPointAndTheRunWaits) {
  const auto run = cell.begin_run(lines_of(3, {2, -3, 1, -1}, true)).id;
  until_accepted(7);
  world.zero_mm -= 5e6;  // 5 km
  cell.until([&] { return cell.status().run->run.state == RunState::waiting; });
  const auto waiting = cell.status().run->run;
  cell.pass(300);
  EXPECT_EQ(cell.status().run->run.accepted, waiting.accepted);
  EXPECT_THAT(alarm_kinds(), testing::Contains("reading.range"));
  world.zero_mm += 5e6;
  EXPECT_EQ(cell.finish_run().state, RunState::done);
  const auto state = cell.await(cell->annotations.exclusions(run));
  ASSERT_TRUE(state);
  EXPECT_THAT(state->rows, ElementsAre());
}

TEST_F(FalseLength, ATrueCampaignHasNoMark) {
  const auto run = cell.begin_run(lines_of(10, {2, -3, 1, -1}, true)).id;
  EXPECT_EQ(cell.finish_run().state, RunState::done);
  EXPECT_THAT(alarm_kinds(), ElementsAre());
  EXPECT_TRUE(cell.await(cell->annotations.exclusions(run))->rows.empty());
  EXPECT_EQ(count("run.trouble"), 0);
}

}  // namespace
}  // namespace driftwise::tests
