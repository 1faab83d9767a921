#include "server/application/trajectories/outlook.h"

#include <gmock/gmock.h>

#include <cmath>

#include "server/application/queue/queue_outlook.h"

namespace driftwise::application {
namespace {

Trajectory outlook_plan(const std::vector<std::pair<std::int64_t, bool>>& lines_and_zeros) {
  Trajectory plan;
  for (const auto& [line, zero] : lines_and_zeros) {
    TrajectoryPoint point;
    point.line = line;
    point.zero = zero;
    plan.points.push_back(point);
  }
  return plan;
}

CellTime instant_s(double s) { return CellTime{} + nanoseconds_from_s(s); }

RunSteps steady_run(std::size_t steps, double took) {
  RunSteps run;
  run.took.assign(steps, took);
  run.visits.assign(steps, 1);
  run.lead_s = 60;
  run.tail_s = 5;
  return run;
}

TEST(PlanLength, CountsDwellsReturnsToZeroAndRowsQueuedAgain) {
  // Line 1 returns by itself; line 2 has a zero of its own; line 3 is the last.
  Trajectory plan = outlook_plan({{1, false}, {1, false}, {2, false}, {2, true}, {3, false}});
  plan.points[1].dwell_s = 30;
  const PlanLength length(plan);
  EXPECT_DOUBLE_EQ(length.ahead({}).visits, 5 + 2);
  EXPECT_DOUBLE_EQ(length.ahead({}).dwell_s, 30);
  EXPECT_DOUBLE_EQ(length.row(0).visits, 1);
  EXPECT_DOUBLE_EQ(length.row(1).visits, 2);
  EXPECT_DOUBLE_EQ(length.row(1).dwell_s, 30);
  Place place;
  place.next_row = 4;
  place.requeued = {{1, 1}};
  EXPECT_DOUBLE_EQ(length.ahead(place).visits, 1 + 1 + 1);
  EXPECT_DOUBLE_EQ(length.ahead(place).dwell_s, 30);
  place = {};
  place.next_row = 5;
  EXPECT_DOUBLE_EQ(length.ahead(place).visits, 0);
}

TEST(PlanLength, NeedsNoReturnBeforeALineThatBeginsAtZero) {
  const PlanLength length(outlook_plan({{1, false}, {2, true}, {2, false}}));
  EXPECT_DOUBLE_EQ(length.ahead({}).visits, 3);
}

TEST(StepMeter, CountsACellsWaitsAndNotThoseOfAPerson) {
  StepMeter meter(10);
  meter.begin(instant_s(0));
  meter.visit_begins(instant_s(100));
  meter.visited(false, {1, 5}, instant_s(125));
  meter.keep(instant_s(130));
  meter.let_go(instant_s(1130));
  meter.visited(false, {2, 0}, instant_s(1155));
  meter.visited(true, {1, 0}, instant_s(1165));  // a row that was queued again
  EXPECT_DOUBLE_EQ(meter.steps().lead_s, 100);
  EXPECT_THAT(meter.steps().took, testing::Pointwise(testing::DoubleNear(1e-9), {2.0, 4.0}));
  EXPECT_EQ(meter.steps().visits, (std::vector<double>{1, 2}));
  EXPECT_DOUBLE_EQ(meter.spent_s(instant_s(1170)), 5);
}

TEST(StepMeter, ReadsTheSameFromTheRecord) {
  const PlanLength plan(outlook_plan({{1, true}, {1, false}}));
  RunRecord run;
  run.started = instant_s(1000);
  run.ended = instant_s(2100);
  run.state = RunState::done;
  const auto attempt = [](std::int64_t row, Verdict verdict, double from, double to) {
    AttemptRecord record;
    record.row = row;
    record.verdict = verdict;
    record.started.utc = instant_s(from);
    record.ended.utc = instant_s(to);
    return record;
  };
  // Row 0 is read again; before row 1 a person keeps the run for 900 s.
  const auto meter =
      meter_of(run,
               {attempt(0, Verdict::reread, 1060, 1070), attempt(0, Verdict::accepted, 1070, 1080),
                attempt(1, Verdict::accepted, 1980, 1990)},
               plan, 10, {instant_s(1979)});
  EXPECT_DOUBLE_EQ(meter.steps().lead_s, 60);
  EXPECT_THAT(meter.steps().took, testing::Pointwise(testing::DoubleNear(1e-9), {2.0, 1.0}));
  EXPECT_DOUBLE_EQ(meter.steps().tail_s, 110);
}

// By hand: 80 of 100 draws are the 60 at 100 s and the 20 next to them.
TEST(Outlook, WhereMostRunsMeetNoWaitTheBandBeginsAtTheirDuration) {
  Outlook outlook;
  outlook.draws_s.assign(60, 100);
  for (int i = 1; i <= 40; ++i) outlook.draws_s.push_back(100 + i);
  take_figures(outlook);
  EXPECT_DOUBLE_EQ(outlook.low_s, 100);
  EXPECT_DOUBLE_EQ(outlook.high_s, 120);
  EXPECT_DOUBLE_EQ(outlook.expected_s, 100);
}

// Quantiles of the logistic distribution: 10 % and 90 % are -ln 9 and ln 9.
TEST(Outlook, OfSymmetricDrawsHasAsManyBelowTheBandAsAbove) {
  Outlook outlook;
  for (int i = 0; i < 1000; ++i) {
    const double share = (i + 0.5) / 1000;
    outlook.draws_s.push_back(std::log(share / (1 - share)));
  }
  take_figures(outlook);
  EXPECT_NEAR(outlook.low_s, -std::log(9), 0.02);
  EXPECT_NEAR(outlook.high_s, std::log(9), 0.02);
  EXPECT_NEAR(outlook.expected_s, 0, 1e-9);
}

TEST(Outlook, WithoutHistoryIsThePlannedFigureWithAWideBand) {
  RunAhead ahead;
  ahead.plan.visits = 100;
  ahead.unit_s = 8;
  ahead.leads = false;
  const auto outlook = look_ahead({}, ahead);
  EXPECT_EQ(outlook.runs, 0);
  EXPECT_NEAR(outlook.expected_s / 800, 1, 0.1);
  EXPECT_LT(outlook.low_s, 800 * 0.65);
  EXPECT_GT(outlook.high_s, 800 * 1.6);
}

TEST(Outlook, OfSteadyRunsIsNarrowAndTheirOwn) {
  DurationHistory history;
  for (int run = 0; run < 10; ++run) history.add(steady_run(200, 1.5));
  RunAhead ahead;
  ahead.plan.visits = 100;
  ahead.unit_s = 8;
  const auto outlook = look_ahead(history, ahead);
  EXPECT_EQ(outlook.runs, 10);
  EXPECT_NEAR(outlook.expected_s, 60 + 1.5 * 800 + 5, 15);
  EXPECT_LT(outlook.high_s - outlook.low_s, 0.25 * outlook.expected_s);
}

TEST(Outlook, FollowsARunThatIsSlowerThanThoseBefore) {
  DurationHistory history;
  for (int run = 0; run < 3; ++run) history.add(steady_run(200, 1));
  const auto so_far = steady_run(60, 2);
  RunAhead ahead;
  ahead.plan.visits = 100;
  ahead.unit_s = 8;
  ahead.leads = false;
  ahead.so_far = &so_far;
  EXPECT_NEAR(look_ahead(history, ahead).expected_s / 1600, 1, 0.1);
}

// An independent check of the bunches: the same steps in bunches and scattered have the same mean
// and the same spread of single steps, but sums of the bunched ones spread more.
TEST(Outlook, IsWiderWhenSlowRowsComeInBunches) {
  const auto run_of = [](std::size_t bunch) {
    RunSteps run = steady_run(400, 1);
    for (std::size_t i = 0; i < run.took.size(); ++i)
      if ((i / bunch) % 4 == 0) run.took[i] = 5;
    return run;
  };
  RunAhead ahead;
  ahead.plan.visits = 60;
  ahead.leads = false;
  const auto width = [&](std::size_t bunch) {
    DurationHistory history;
    for (int run = 0; run < 10; ++run) history.add(run_of(bunch));
    const auto outlook = look_ahead(history, ahead);
    return outlook.high_s - outlook.low_s;
  };
  EXPECT_GT(width(20), 1.5 * width(1));
}

TEST(Outlook, OfAWaitUnderWayKeepsWhatIsAhead) {
  DurationHistory history;
  for (int run = 0; run < 5; ++run) history.add(steady_run(200, 1));
  RunAhead ahead;
  ahead.plan.visits = 50;
  ahead.unit_s = 10;
  ahead.leads = false;
  ahead.spent_s = 7200;
  EXPECT_GT(look_ahead(history, ahead).low_s, 400);
}

// Three entries that wait, drawn from ten steady runs.
struct WaitingThree {
  WaitingThree() {
    auto runs = std::make_shared<DurationHistory>();
    for (int run = 0; run < 10; ++run) runs->add(steady_run(200, 1));
    history = std::move(runs);
    for (int i = 0; i < 3; ++i) {
      entries[static_cast<std::size_t>(i)].id = QueueEntryId{i + 1};
      entries[static_cast<std::size_t>(i)].place = i;
    }
    queue.entries = &entries;
    queue.cell_time = [](UtcTime utc) { return CellTime{utc.ns}; };
    queue.lengths = &lengths;
    draw();
  }
  WaitingThree(const WaitingThree&) = delete;
  void draw() {
    for (const auto& entry : entries) {
      auto& length = lengths[entry.id];
      length.ahead = run_ahead(entry, {100, 0}, rules);
      length.history = history;
      length.run = look_ahead(*history, length.ahead);
    }
  }
  double run_s(int id) const { return look_ahead(queue).at(QueueEntryId{id}).run.expected_s; }

  std::shared_ptr<const DurationHistory> history;
  std::vector<QueueEntry> entries{3};
  std::map<QueueEntryId, EntryLength> lengths;
  RunRules rules;
  QueueAhead queue;
};

TEST(QueueOutlook, AddsUpWhatIsBeforeAndStopsAtACondition) {
  WaitingThree three;
  three.entries[1].not_before = UtcTime{nanoseconds_from_s(36'000).count()};
  three.entries[2].condition = "t01_degC < 20 degC";
  const double run_s = 100 * planned_visit_s(three.rules) + 65;
  const auto all = look_ahead(three.queue);
  EXPECT_NEAR(all.at(QueueEntryId{1}).end->expected_s, run_s, 0.05 * run_s);
  EXPECT_NEAR(all.at(QueueEntryId{2}).end->expected_s, 36'000 + run_s, 0.05 * run_s);
  EXPECT_FALSE(all.at(QueueEntryId{3}).end);
  EXPECT_NEAR(all.at(QueueEntryId{3}).run.expected_s, run_s, 0.05 * run_s);
  // A set-up alone states no rules.
  three.rules.settle_s += 60;
  three.draw();
  const double by_the_cell_s = three.run_s(1);
  three.entries[0].rules_json = R"({"setup":"height"})";
  three.draw();
  EXPECT_EQ(three.run_s(1), by_the_cell_s);
  EXPECT_GT(by_the_cell_s, run_s);
  three.queue.held = true;
  EXPECT_FALSE(look_ahead(three.queue).at(QueueEntryId{1}).end);
}

TEST(QueueOutlook, IsTheSumOfTheDrawsThatAreKept) {
  WaitingThree three;
  for (auto& [id, length] : three.lengths) length.run.draws_s.assign(500, 100);
  auto all = look_ahead(three.queue);
  EXPECT_DOUBLE_EQ(all.at(QueueEntryId{3}).end->expected_s, 300);
  EXPECT_TRUE(all.at(QueueEntryId{3}).end->draws_s.empty());
  // One without draws: it has no outlook, and those behind it have no end.
  three.lengths[QueueEntryId{2}].history.reset();
  all = look_ahead(three.queue);
  EXPECT_DOUBLE_EQ(all.at(QueueEntryId{1}).end->expected_s, 100);
  EXPECT_FALSE(all.contains(QueueEntryId{2}));
  EXPECT_FALSE(all.at(QueueEntryId{3}).end);
}

TEST(QueueOutlook, OfOneEntryIsThatOfTheListAndLooksAtNoneBehindIt) {
  WaitingThree three;
  const auto all = look_ahead(three.queue);
  three.queue.only = QueueEntryId{2};
  const auto one = look_ahead(three.queue);
  EXPECT_EQ(one.at(QueueEntryId{2}).end->expected_s, all.at(QueueEntryId{2}).end->expected_s);
  EXPECT_EQ(one.at(QueueEntryId{2}).end->high_s, all.at(QueueEntryId{2}).end->high_s);
  EXPECT_FALSE(one.contains(QueueEntryId{3}));
}

}  // namespace
}  // namespace driftwise::application
