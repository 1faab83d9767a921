// Returns to zero of whole runs: judged with their budget, and what follows.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <sstream>

#include "server/application/datasets/amended_dataset.h"
#include "server/application/datasets/joined_runs.h"
#include "server/application/motion/datum_opening.h"
#include "server/core/data/row_marks.h"
#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

using testing::AllOf;
using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class Closing : public testing::Test {
 protected:
  CellInMemory& cell() {
    if (!cell_) cell_.emplace(world, description, kSqlite);
    return *cell_;
  }
  // [closure] of the cell file.
  void rules(const std::string& text) { description.text = text; }
  std::vector<PointId> repeated(RunId run) {
    return *cell().await(
        cell().read([run](Store& store) { return store.closures().repeated_points(run); }));
  }
  std::vector<ClosureRecord> closures(RunId run) {
    return *cell().await(
        cell().read([run](Store& store) { return store.closures().closures(run); }));
  }
  std::vector<ClosureDecision> decisions(RunId run) {
    std::vector<ClosureDecision> all;
    for (const auto& closure : closures(run)) all.push_back(closure.decision);
    return all;
  }
  // Rows of the plan alone.
  Dataset dataset(RunId run) {
    auto rows = *cell().await(
        cell().read([run](Store& store) { return store.runs().dataset(std::vector{run}); }));
    leave_passages_out(rows);
    return rows;
  }
  std::vector<PointRecord> points(RunId run) { return *cell().await(cell().points(run, 0, 1000)); }
  void until_accepted(std::int64_t count) {
    cell().until([&] { return cell().status().run->run.accepted >= count; });
  }
  std::vector<std::int64_t> suspects(RunId run) {
    return cell().await(cell()->annotations.exclusions(run))->suspect_rows;
  }

  Folder folder;
  SmallWorld world;
  CellDescription description = small_cell(folder / "cell.sqlite");
  std::optional<CellInMemory> cell_;
};

constexpr double kJump_mm = 0.010;

TEST_F(Closing, EveryReturnIsOnRecordWithItsBudget) {
  const auto run = cell().begin_run(lines_of(3, {2, -3}, false)).id;
  EXPECT_EQ(cell().finish_run().state, RunState::done);
  const auto all = closures(run);
  ASSERT_THAT(all, SizeIs(3));
  for (const auto& closure : all) {
    EXPECT_EQ(closure.decision, ClosureDecision::within);
    ASSERT_THAT(closure.coordinates, SizeIs(1));
    const auto& x = closure.coordinates.front();
    EXPECT_EQ(x.channel, "x_mm");
    EXPECT_GE(x.limit, 300);
    EXPECT_LT(std::abs(x.found), 100);
    EXPECT_THAT(closure.sentence, HasSubstr(": accept"));
    EXPECT_EQ(closure.side, "q1-") << "from -3 mm";
  }
  EXPECT_EQ(all.back().by, "2 earlier returns");
}

TEST_F(Closing, ALineIsMeasuredAgainAndTheDatasetHasOnePointPerRow) {
  rules("[closure]\nunexplained = \"repeat\"\n");
  const auto run = cell().begin_run(lines_of(3, {2, -3, 1, -1}, true)).id;
  until_accepted(8);  // in the second line
  world.zero_mm -= kJump_mm;
  const auto ended = cell().finish_run();
  EXPECT_EQ(ended.state, RunState::done) << ended.reason;
  EXPECT_EQ(ended.accepted, 15);
  EXPECT_EQ(ended.given_up, 0);
  const auto rows = dataset(run);
  EXPECT_EQ(rows.rows, 15u);
  EXPECT_THAT(rows.excluded, IsEmpty()) << "nothing is suspect: it was measured again";
  const auto all = points(run);
  const auto old = repeated(run);
  std::multiset<std::int64_t> again;
  for (const auto& point : all)
    if (std::ranges::binary_search(old, point.id)) again.insert(point.row);
  EXPECT_THAT(again, ElementsAre(6, 7, 8, 9, 10)) << "the old points stay, marked";
  EXPECT_THAT(all, SizeIs(20));
  std::set<std::int64_t> data;
  for (const auto& point : all)
    if (!std::ranges::binary_search(old, point.id) && again.contains(point.row))
      data.insert(point.datum.value);
  EXPECT_THAT(data, SizeIs(1)) << "the line rests on one zero";
  EXPECT_THAT(cell().alarms_of("closure.bad"), IsEmpty());
  EXPECT_EQ(cell().events_named("closure.repeat").size(), 1u);
  const auto judged = closures(run);
  const auto repeated =
      std::ranges::find(judged, ClosureDecision::repeated, &ClosureRecord::decision);
  ASSERT_NE(repeated, judged.end());
  EXPECT_EQ(repeated->line, 2);
  EXPECT_THAT(repeated->sentence, HasSubstr("unexplained, repeat the line (1 of 2)"));
  EXPECT_NEAR(std::abs(repeated->coordinates.front().found), 1e4, 100);
}

TEST_F(Closing, ARunWithARepeatedLineIsCorrectedAndJoinedAsAnyOther) {
  rules("[closure]\nunexplained = \"repeat\"\n");
  const auto run = cell().begin_run(lines_of(3, {2, -3}, false)).id;
  until_accepted(1);
  world.zero_mm -= kJump_mm;
  ASSERT_EQ(cell().finish_run().state, RunState::done);
  const auto all = *cell().await(cell().points(run, 0, 1000, true));
  const auto old = repeated(run);
  EXPECT_EQ(std::ranges::count_if(points(run),
                                  [&old](const PointRecord& point) {
                                    return std::ranges::binary_search(old, point.id);
                                  }),
            2);
  const auto amended = cell().await(cell().read(
      [run](Store& store) { return application::amended_data(store, std::vector{run}); }));
  ASSERT_TRUE(amended) << amended.error().message;
  EXPECT_EQ(amended->data.rows, 10u) << "from the zero of the second datum over three returns";
  EXPECT_EQ(std::ranges::count(amended->data.excluded, kPassageRow), 4);
  EXPECT_THAT(amended->origins, SizeIs(10));
  const auto parts = cell().await(cell().read([this, run](Store& store) {
    return application::join_parts(store, std::vector{run}, description);
  }));
  ASSERT_TRUE(parts) << parts.error().message;
  EXPECT_THAT(parts->front().row, ElementsAre(0, 1, 2, 3, 4, 5));

  const auto csv = cell().await(cell()->datasets.export_csv({run}, false));
  ASSERT_TRUE(csv) << csv.error().message;
  for (const auto& point : all) {
    if (std::ranges::binary_search(old, point.id)) continue;
    EXPECT_EQ(amended->time_zero, point.measured.utc);
    EXPECT_THAT(*csv, HasSubstr("# time_zero: " + to_iso8601(point.measured.utc) + "\n"))
        << "time_s is 0 there";
    break;
  }
}

// The room warms by 2 K in the first line, which is measured again from a zero of its own.
TEST_F(Closing, ARunIsCheckedFromTheZeroOfItsRowsAndNotOfTheRepeatedOnes) {
  rules("[closure]\nunexplained = \"repeat\"\n");
  world.warming_k_per_h = 6;
  application::FitRequest fit;
  fit.runs = {cell().begin_run(lines_of(14, {2, -3, 1, -1, 3, -2}, true)).id};
  EXPECT_EQ(cell().finish_run().state, RunState::done);
  fit.formula = "q ~ x + T";
  const auto model = cell().await(cell()->models.fit(cell().ada, fit));
  ASSERT_TRUE(model) << model.error().message;

  const auto run = cell().begin_run(lines_of(4, {2, -3, 1, -1, 3, -2}, false)).id;
  until_accepted(1);
  ASSERT_TRUE(cell().await(cell()->runs.pause(cell().ada, run)));
  cell().until([&] { return cell().status().run->run.state == RunState::paused; });
  cell().pass(1200);
  world.zero_mm -= kJump_mm;
  ASSERT_TRUE(cell().resume());
  EXPECT_EQ(cell().finish_run().state, RunState::done);
  ASSERT_FALSE(repeated(run).empty());
  ASSERT_THAT(dataset(run).datum, IsEmpty()) << "one zero";
  const auto check = cell().await(cell()->checks.check_model(model->id, {run}));
  ASSERT_TRUE(check) << check.error().message;
  const auto& point = check->report.outputs.at(0).points.at(0);
  ASSERT_TRUE(point.judged) << point.why_not;
  EXPECT_LT(std::abs(point.bias), 100) << "2 K are 300 nm";
}

TEST_F(Closing, ALineThatIsRepeatedInVainIsSuspectWithAnAlarm) {
  rules("[closure]\nunexplained = \"repeat\"\nrepeats = 1\n");
  const auto run = cell().begin_run(lines_of(2, {2, -3}, false)).id;
  until_accepted(1);
  world.zero_mm -= kJump_mm;
  cell().until([&] { return cell().events_named("datum.opened").size() == 2; });
  until_accepted(1);
  world.zero_mm -= kJump_mm;
  EXPECT_EQ(cell().finish_run().state, RunState::done);
  EXPECT_THAT(decisions(run), ElementsAre(ClosureDecision::repeated, ClosureDecision::new_datum,
                                          ClosureDecision::within));
  EXPECT_EQ(closures(run)[1].repetition, 1);
  EXPECT_THAT(suspects(run), ElementsAre(0, 1));
  EXPECT_EQ(dataset(run).rows, 4u);
  const auto events = cell().events_named("closure.bad");
  EXPECT_EQ(events.size(), 1u);
}

TEST_F(Closing, AMarkedLineKeepsItsDatum) {
  rules("[closure]\nunexplained = \"mark\"\n");
  const auto run = cell().begin_run(lines_of(3, {2, -3}, false)).id;
  until_accepted(3);
  world.zero_mm -= kJump_mm;
  EXPECT_EQ(cell().finish_run().state, RunState::done);
  EXPECT_THAT(decisions(run), ElementsAre(ClosureDecision::within, ClosureDecision::marked,
                                          ClosureDecision::within));
  EXPECT_THAT(suspects(run), ElementsAre(2, 3));
  EXPECT_EQ(cell().events_named("datum.opened").size(), 1u);
}

TEST_F(Closing, ACoordinateHasALimitOfItsOwn) {
  rules("[[closure_limit]]\nchannel = \"x_mm\"\nlimit_nm = 100000\n");
  const auto run = cell().begin_run(lines_of(2, {2, -3}, false)).id;
  until_accepted(1);
  world.zero_mm -= kJump_mm;
  EXPECT_EQ(cell().finish_run().state, RunState::done);
  EXPECT_THAT(decisions(run), Each(ClosureDecision::within));
}

// 150 nm per K and 6 K/h: 15 nm a minute.
TEST_F(Closing, WhatTheEarlierReturnsExplainIsAccepted) {
  world.warming_k_per_h = 6;
  description.plausibility.closure_nm_per_min = 0;
  rules("[[closure_limit]]\nchannel = \"x_mm\"\nlimit_nm = 100\n");
  const auto run = cell().begin_run(lines_of(20, {2, -3}, false)).id;
  until_accepted(33);
  ASSERT_TRUE(cell().await(cell()->runs.pause(cell().ada, run)));
  cell().until([&] { return cell().status().run->run.state == RunState::paused; });
  cell().pass(1200);  // 300 nm
  ASSERT_TRUE(cell().resume());
  EXPECT_EQ(cell().finish_run().state, RunState::done);
  const auto all = closures(run);
  ASSERT_THAT(all, SizeIs(20));
  const auto& after = all[17];
  EXPECT_EQ(after.decision, ClosureDecision::explained) << after.sentence;
  EXPECT_THAT(after.sentence, HasSubstr("by 17 earlier returns: accept"));
  EXPECT_THAT(after.sentence, HasSubstr("is expected from +2."));
  EXPECT_NEAR(after.coordinates.front().expected, after.coordinates.front().found, 60);
  EXPECT_GT(std::abs(after.coordinates.front().found), 100);
  EXPECT_THAT(suspects(run), IsEmpty());
}

// The same drift in the first line of a second run: only the model that serves can expect it. The
// model was measured over a wider range of temperature than the second run meets. By the world's
// own law: 150 nm for each K of t01.
TEST_F(Closing, WhatTheServingModelExplainsIsAcceptedInTheFirstLine) {
  world.warming_k_per_h = 12;
  description.plausibility.closure_nm_per_min = 0;
  rules("[[closure_limit]]\nchannel = \"x_mm\"\nlimit_nm = 100\n");
  application::FitRequest fit;
  fit.runs = {cell().begin_run(lines_of(60, {2, -3, 1, -1, 3}, false)).id};
  EXPECT_EQ(cell().finish_run().state, RunState::done);
  fit.formula = "q ~ x + t01";
  const auto model = cell().await(cell()->models.fit(cell().ada, fit));
  ASSERT_TRUE(model) << model.error().message;
  ASSERT_TRUE(cell().await(cell()->promotions.promote(cell().ada, model->id)));

  // The room has cooled to the middle of that range, and warms half as fast.
  world.warming_k_per_h = 6;
  const auto t01_degc = [this] {
    return 20.1 + 6 * seconds_from(cell().now() - kWorldBegin) / 3600;
  };
  const auto run = cell().begin_run(lines_of(2, {2, -3, 1, -1, 3}, false)).id;
  until_accepted(1);
  const double before_degc = t01_degc();
  ASSERT_TRUE(cell().await(cell()->runs.pause(cell().ada, run)));
  cell().until([&] { return cell().status().run->run.state == RunState::paused; });
  cell().pass(900);
  ASSERT_TRUE(cell().resume());
  cell().until([&] { return !closures(run).empty(); });
  const double by_law_nm = 150 * (t01_degc() - before_degc);
  EXPECT_GT(by_law_nm, 200) << "beyond the limit";
  const auto first = closures(run).front();
  EXPECT_EQ(first.decision, ClosureDecision::explained) << first.sentence;
  EXPECT_EQ(first.by, "model 1");
  const auto& x = first.coordinates.front();
  EXPECT_NEAR(std::abs(x.expected), by_law_nm, 40) << "from the datum to this return";
  EXPECT_NEAR(x.found, x.expected, 40) << "with its sign: what was measured";
  EXPECT_EQ(cell().finish_run().state, RunState::done);
  EXPECT_THAT(suspects(run), IsEmpty());
}

// Lines that end on one side and on the other in turn.
std::string both_sides(int lines) {
  std::ostringstream csv;
  csv << "q1_mm,set,line,zero\n";
  for (int line = 1; line <= lines; ++line)
    csv << -2 * (line % 2 == 0 ? 1 : -1) << ",calibration," << line << ",0\n"
        << 3 * (line % 2 == 0 ? 1 : -1) << ",calibration," << line << ",0\n";
  return csv.str();
}

TEST_F(Closing, APlayIsFoundByTheOtherSideAndNoLineIsSuspect) {
  world.play_nm = 900;
  const auto run = cell().begin_run(both_sides(6)).id;
  EXPECT_EQ(cell().finish_run().state, RunState::done);
  const auto all = closures(run);
  ASSERT_THAT(all, SizeIs(6));
  EXPECT_THAT(suspects(run), IsEmpty());
  EXPECT_EQ(cell().events_named("datum.opened").size(), 1u);
  int plays = 0;
  for (const auto& closure : all) {
    if (closure.decision != ClosureDecision::play) continue;
    ++plays;
    EXPECT_NEAR(std::abs(closure.coordinates.front().play), 900, 60);
    EXPECT_THAT(closure.sentence, HasSubstr("play"));
  }
  EXPECT_EQ(plays, 1) << "after that each side is compared with itself";
}

TEST_F(Closing, AJumpIsNoPlay) {
  world.play_nm = 900;
  const auto run = cell().begin_run(both_sides(4)).id;
  until_accepted(5);
  world.zero_mm -= kJump_mm;
  EXPECT_EQ(cell().finish_run().state, RunState::done);
  EXPECT_THAT(suspects(run), ElementsAre(4, 5));
  EXPECT_EQ(cell().events_named("closure.bad").size(), 1u);
}

// The limit grows with the minutes, by much here. A jump that is a little beyond it at the first
// look is no play because it would be within it after the second.
TEST_F(Closing, AJumpJustBeyondTheLimitIsNoPlay) {
  description.plausibility.closure_nm_per_min = 6000;
  const auto first = cell().begin_run(both_sides(2)).id;
  EXPECT_EQ(cell().finish_run().state, RunState::done);
  const auto usual = closures(first)[1].coordinates.front();
  EXPECT_LT(std::abs(usual.found), 100);

  const auto run = cell().begin_run(both_sides(2)).id;
  until_accepted(3);
  world.zero_mm -= (usual.limit + 300) * 1e-6;
  EXPECT_EQ(cell().finish_run().state, RunState::done);
  const auto jumped = closures(run)[1];
  EXPECT_EQ(jumped.decision, ClosureDecision::new_datum) << jumped.sentence;
  EXPECT_NEAR(jumped.coordinates.front().limit, usual.limit, 250) << "the same line as before";
  EXPECT_THAT(suspects(run), ElementsAre(2, 3));
}

// One of four readings is off by 3 um.
TEST_F(Closing, AReturnWhoseReadingsDisagreeIsReadAgain) {
  world.warming_k_per_h = 0;
  world.disturbance_nm = 3000;
  const auto run = cell().begin_run(lines_of(3, {1, 2, -1}, false)).id;
  cell().until([&] {
    const auto now = *cell().status().run;
    return now.run.accepted == 3 && now.phase == "settling" && std::abs(world.to_mm) < 1e-3;
  });
  world.disturbed_readings = 1;
  EXPECT_EQ(cell().finish_run().state, RunState::done);
  EXPECT_THAT(decisions(run), AllOf(SizeIs(3), Each(ClosureDecision::within)));
  EXPECT_THAT(cell().events_named("zero.again"),
              ElementsAre(AllOf(HasSubstr("zero after line 1: spread"), HasSubstr("read again"))));
  EXPECT_THAT(cell().alarms_of("closure.bad"), IsEmpty());
  EXPECT_THAT(suspects(run), IsEmpty());
}

TEST_F(Closing, ADatumWhoseReadingsDisagreeIsReadAgain) {
  world.warming_k_per_h = 0;
  world.disturbance_nm = 1100;
  const auto run = cell().begin_run(lines_of(1, {1, 2}, true)).id;
  cell().until([&] { return world.zeroings == 1; });
  world.disturbed_readings = 1;
  EXPECT_EQ(cell().finish_run().state, RunState::done);
  const auto data = *cell().await(cell().datums(run));
  ASSERT_THAT(data, SizeIs(1));
  const double* q1_mm = application::find_value(data[0].values, "q1_mm");
  ASSERT_NE(q1_mm, nullptr);
  EXPECT_NEAR(*q1_mm, 0, 40e-6) << "the scale's own noise, and not a quarter of the disturbance";
  EXPECT_THAT(cell().events_named("zero.again"), SizeIs(1));
}

TEST_F(Closing, AReturnThatDoesNotBecomeGoodAsksAPersonAndLosesNothing) {
  const auto run = cell().begin_run(lines_of(2, {1, 2}, false)).id;
  until_accepted(2);
  world.disturbed_readings = 1'000'000;
  cell().until([&] { return cell().status().run->run.hold.kind == RunHold::Kind::trouble; });
  EXPECT_THAT(cell().status().run->run.reason,
              AllOf(HasSubstr("zero after line 1: spread"), HasSubstr("max_rereads")));
  EXPECT_EQ(cell().status().run->run.accepted, 2);
  world.disturbed_readings = 0;
  ASSERT_TRUE(cell().resume());
  EXPECT_EQ(cell().finish_run().state, RunState::done);
  EXPECT_THAT(decisions(run), AllOf(SizeIs(2), Each(ClosureDecision::within)));
}

// The controller's search for its reference ends from the other side than the axis came from last.
TEST_F(Closing, AZeroAfterHomingIsOfNoKnownSide) {
  world.play_nm = 900;
  world.warming_k_per_h = 0;
  cell().begin_run(lines_of(3, {-3, -1}, false));
  until_accepted(3);  // on the way to -1 mm, from below as at the next return
  world.referenced = false;
  cell().until([&] { return cell().status().run->run.state == RunState::paused; });
  const int homes = world.homes;
  ASSERT_TRUE(cell().resume());
  cell().until([&] { return world.homes > homes; });
  world.came_down = true;
  const auto ended = cell().finish_run();
  EXPECT_EQ(ended.state, RunState::done) << ended.reason;
  EXPECT_THAT(cell().events_named("closure.bad"), IsEmpty());
  const auto all = decisions(ended.id);
  ASSERT_THAT(all, SizeIs(3));
  EXPECT_EQ(all[1], ClosureDecision::play) << "the first return after it is seen from both sides";
}

}  // namespace
}  // namespace driftwise::tests
