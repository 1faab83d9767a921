// Whatever moved the axes is a row: what a run does beside its plan is in the path of its dataset,
// and in no count, fit or figure.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "server/application/motion/datum_opening.h"
#include "server/core/data/row_marks.h"
#include "server/formats/csv/dataset_csv.h"
#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class Passages : public testing::Test {
 protected:
  CellInMemory& cell() {
    if (!cell_) cell_.emplace(world, description, kSqlite);
    return *cell_;
  }
  RunRecord measured(const std::string& trajectory) {
    cell().begin_run(trajectory);
    return cell().finish_run();
  }
  Dataset dataset(RunId run) {
    return *cell().await(
        cell().read([run](Store& store) { return store.runs().dataset(std::vector{run}); }));
  }
  std::vector<PointRecord> points(RunId run) {
    return *cell().await(cell().points(run, 0, 1000, true));
  }
  std::vector<PointRecord> passages(RunId run) {
    auto all = points(run);
    std::erase_if(all, [](const PointRecord& point) { return !point.passage; });
    return all;
  }
  void until_accepted(std::int64_t count) {
    cell().until([&] { return cell().status().run->run.accepted >= count; });
  }

  Folder folder;
  SmallWorld world;
  CellDescription description = small_cell(folder / "cell.sqlite");
  std::optional<CellInMemory> cell_;
};

auto NearNm(double mm) { return testing::DoubleNear(mm, 1e-3); }

std::vector<double> commanded_mm(const std::vector<PointRecord>& points) {
  std::vector<double> all;
  for (const auto& point : points) all.push_back(point.commanded_mm.front());
  return all;
}

TEST_F(Passages, AReturnOfItsOwnIsARowAfterEachLine) {
  const auto run = measured(lines_of(3, {2, -3}, false));
  EXPECT_EQ(run.accepted, 6);
  EXPECT_EQ(run.attempts, 6);
  EXPECT_EQ(run.rows, 6);
  const auto all = points(run.id);
  EXPECT_THAT(commanded_mm(all), ElementsAre(0, 2, -3, 0, 2, -3, 0, 2, -3, 0))
      << "in the order in which the robot was there, from its first datum on";
  EXPECT_TRUE(
      std::ranges::is_sorted(all, {}, [](const PointRecord& point) { return point.measured.utc; }));
  const auto returns = passages(run.id);
  ASSERT_THAT(returns, SizeIs(4));
  EXPECT_EQ(returns[0].row, 6);
  EXPECT_EQ(returns[0].line, 1);
  EXPECT_EQ(application::find_value(returns[0].values, "x_mm"), nullptr) << "it counts from there";
  for (std::size_t i = 1; i < 4; ++i) {
    EXPECT_TRUE(returns[i].zero);
    EXPECT_EQ(returns[i].line, static_cast<std::int64_t>(i));
    EXPECT_EQ(returns[i].row, static_cast<std::int64_t>(6 + i));
    EXPECT_GT(returns[i].dwell_s, 0);
    for (const char* channel : {"q1_mm", "x_mm", "t01_degC", "t05_degC"})
      EXPECT_NE(application::find_value(returns[i].values, channel), nullptr) << channel;
  }
  const auto rows = dataset(run.id);
  EXPECT_THAT(rows.excluded, ElementsAre(4, 0, 0, 4, 0, 0, 4, 0, 0, 4));
  EXPECT_THAT(rows.zero, ElementsAre(1, 0, 0, 1, 0, 0, 1, 0, 0, 1));
  EXPECT_TRUE(std::ranges::is_sorted(rows.time_s, std::less_equal<>()));
}

TEST_F(Passages, APlanWithItsOwnReturnsHasNone) {
  const auto run = measured(lines_of(3, {2, -3}, true));
  EXPECT_EQ(run.accepted, 9);
  EXPECT_THAT(passages(run.id), SizeIs(0));
  EXPECT_THAT(dataset(run.id).excluded, IsEmpty());
  const auto csv = cell().await(cell()->datasets.export_csv({run.id}, false));
  EXPECT_THAT(*csv, testing::Not(HasSubstr("passage")));
}

// Read three times in vain, then approached from a little way towards the zero.
TEST_F(Passages, AnApproachFromAsideIsInThePath) {
  cell().begin_run(lines_of(1, {2, -3}, false));
  until_accepted(1);
  world.disturbed_readings = 12;
  const auto run = cell().finish_run();
  EXPECT_EQ(run.accepted, 2);
  EXPECT_EQ(run.attempts, 5);
  const auto all = points(run.id);
  EXPECT_THAT(commanded_mm(all), ElementsAre(0, 2, -3, -2.9, -3, 0));
  std::vector<bool> beside;
  for (const auto& point : all) beside.push_back(point.passage);
  EXPECT_THAT(beside, ElementsAre(true, false, true, true, false, true));
  EXPECT_THAT(dataset(run.id).find("x")->values,
              ElementsAre(testing::IsNan(), NearNm(2), testing::IsNan(), testing::IsNan(),
                          NearNm(-3), NearNm(0)))
      << "no instrument was read beside the row";
}

// 3 is reached from above, and approached again from there: towards zero it would come from below.
TEST_F(Passages, AnApproachFromAsideKeepsTheSideOfThePlan) {
  cell().begin_run(
      "q1_mm,set,line,zero\n2,calibration,1,0\n4,calibration,1,0\n"
      "3,calibration,1,0\n");
  until_accepted(2);
  world.disturbed_readings = 12;
  const auto run = cell().finish_run();
  EXPECT_EQ(run.accepted, 3);
  EXPECT_THAT(commanded_mm(points(run.id)), ElementsAre(0, 2, 4, 3, 3.1, 3, 0));
}

TEST_F(Passages, WhereAStopOrAPersonLeftTheAxesIsInThePath) {
  const auto id = cell().begin_run(lines_of(3, {2, -3}, false)).id;
  until_accepted(2);
  const auto until_paused = [this] {
    cell().until([&] { return cell().status().run->run.state == RunState::paused; });
  };
  ASSERT_TRUE(cell().await(cell()->runs.pause(cell().ada, id)));
  until_paused();
  ASSERT_TRUE(
      cell().await(cell()->manual.move_to(cell().ada, cell().lease(), {4.5}, cell().answer())));
  ASSERT_TRUE(cell().resume());
  until_accepted(3);
  cell().until([&] { return cell().status().run->phase == "moving"; });
  cell().pass(0.6);
  static_cast<void>(cell().await(cell()->manual.stop_all(cell().ada)));
  until_paused();
  const double stopped_mm = world.to_mm + world.reference_mm;
  EXPECT_GT(stopped_mm, -2.9);
  EXPECT_LT(stopped_mm, 1.9);
  ASSERT_TRUE(cell().resume());
  EXPECT_EQ(cell().finish_run().state, RunState::done);
  const auto data = dataset(id);
  EXPECT_THAT(data.find("q1_cmd")->values,
              ElementsAre(0, 2, -3, 0, NearNm(4.5), 0, 2, NearNm(stopped_mm), -3, 0, 2, -3, 0));
  EXPECT_THAT(data.excluded, ElementsAre(4, 0, 0, 4, 4, 4, 0, 4, 0, 4, 0, 0, 4));
  EXPECT_TRUE(std::ranges::is_sorted(data.time_s, std::less_equal<>()));
}

// Axes that stand where the run left them are in no second row.
TEST_F(Passages, APauseAloneIsNoPlace) {
  const auto id = cell().begin_run(lines_of(2, {2, -3}, true)).id;
  until_accepted(2);
  ASSERT_TRUE(cell().await(cell()->runs.pause(cell().ada, id)));
  cell().until([&] { return cell().status().run->run.state == RunState::paused; });
  ASSERT_TRUE(cell().resume());
  world.laser_away = true;
  cell().until([&] { return cell().status().run->run.state == RunState::waiting; });
  world.laser_away = false;
  EXPECT_EQ(cell().finish_run().state, RunState::done);
  EXPECT_THAT(passages(id), IsEmpty());
}

TEST_F(Passages, ARestartShowsTheWayOverItsNewZero) {
  const auto id = cell().begin_run(lines_of(3, {2, -3}, false)).id;
  until_accepted(3);
  const auto later = cell().now() + std::chrono::minutes(10);
  cell().shut_down();
  cell_.reset();
  cell_.emplace(world, description, kSqlite, later);
  const auto run = cell().finish_run();
  EXPECT_EQ(run.id, id);
  EXPECT_EQ(run.state, RunState::done);
  EXPECT_EQ(run.accepted, 6);
  EXPECT_EQ(run.given_up, 0);
  auto plan = points(id);
  std::erase_if(plan, [](const PointRecord& point) { return point.passage; });
  std::vector<std::int64_t> rows;
  for (const auto& point : plan) rows.push_back(point.row);
  EXPECT_THAT(rows, ElementsAre(0, 1, 2, 3, 4, 5)) << "each row once";
  const auto data = dataset(id);
  std::vector<double> q_mm;
  for (const double q : data.find("q1_cmd")->values) q_mm.push_back(q);
  EXPECT_EQ(std::ranges::count(q_mm, 0.0), 5) << "three lines, and the zeros of two datums";
  EXPECT_EQ(std::ranges::count(data.excluded, kPassageRow), 5);
}

TEST_F(Passages, AnExportTellsThemAndLeavesThemOut) {
  const auto run = measured(lines_of(2, {2, -3}, false));
  const auto csv = cell().await(cell()->datasets.export_csv({run.id}, false));
  ASSERT_TRUE(csv) << csv.error().message;
  const auto whole = formats::read_dataset_csv(*csv, "run.csv");
  ASSERT_TRUE(whole) << whole.error().message;
  EXPECT_EQ(whole->rows, 7u);
  EXPECT_EQ(std::ranges::count(whole->excluded, kPassageRow), 3);
  const auto without = cell().await(cell()->datasets.export_csv({run.id}, true));
  EXPECT_EQ(formats::read_dataset_csv(*without, "run.csv")->rows, 4u);
  EXPECT_THAT(cell().await(cell()->annotations.exclusions(run.id))->history, IsEmpty())
      << "nobody said anything about a row";
}

}  // namespace
}  // namespace driftwise::tests
