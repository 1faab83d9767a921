// Outlook of the entries in a list: kept, so that a page that asks every few seconds costs no
// draws.

#include <gmock/gmock.h>

#include <ctime>

#include "tests/unit/application/queue/queue_cell.h"

namespace driftwise::tests {
namespace {

double thread_cpu_s() {
  timespec used{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &used);
  return static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec);
}

QueueDraft with_lines(const std::string& name, int lines) {
  auto d = draft(name);
  d.trajectory_text = lines_of(lines, {-4, -2, 1, 3}, true);
  return d;
}

TEST_F(QueueTest, AListCostsLessThanTheDrawsOfOneEntry) {
  constexpr int kLines = 250;
  until(add(with_lines("history", 4)), QueueState::done);
  cell.lease();  // so that all of them wait
  for (int i = 0; i < 5; ++i) add(with_lines("night", kLines));
  const auto are_drawn = [this] {
    const auto lines = cell->queue.list().lines;
    return std::ranges::all_of(lines, [](const QueueLine& line) {
      return line.entry.state != QueueState::waiting ||
             (line.outlook && line.outlook->run.runs == 1 && line.outlook->end);
    });
  };
  cell.until(are_drawn, 600);
  double list_s = 1e9;
  for (int i = 0; i < 3; ++i) {
    const double before_s = thread_cpu_s();
    EXPECT_EQ(cell->queue.list().lines.size(), 6U);
    list_s = std::min(list_s, thread_cpu_s() - before_s);
  }
  application::RunSteps steps;
  steps.took.assign(20, 1);
  steps.visits.assign(20, 1);
  application::DurationHistory history;
  history.add(steps);
  application::RunAhead one;
  one.plan.visits = 5 * kLines;
  const double before_s = thread_cpu_s();
  EXPECT_GT(look_ahead(history, one).expected_s, 0);
  EXPECT_LT(list_s, thread_cpu_s() - before_s);
}

TEST_F(QueueTest, OneEntryHasTheOutlookOfTheList) {
  until(add(with_lines("history", 4)), QueueState::done);
  cell.lease();
  for (int i = 0; i < 3; ++i) add(with_lines("night", 4));
  cell.until([this] { return cell->queue.list().lines[2].outlook.has_value(); }, 600);
  cell.pass(10);
  const auto lines = cell->queue.list().lines;
  ASSERT_EQ(lines.size(), 4U);
  for (const auto& line : lines) {
    const auto one = cell->queue.get(line.entry.id);
    ASSERT_EQ(one->outlook.has_value(), line.outlook.has_value());
    if (!line.outlook) continue;
    ASSERT_TRUE(line.outlook->end);
    EXPECT_EQ(one->outlook->run.expected_s, line.outlook->run.expected_s);
    EXPECT_EQ(one->outlook->end->expected_s, line.outlook->end->expected_s);
    EXPECT_EQ(one->outlook->end->high_s, line.outlook->end->high_s);
  }
  EXPECT_GT(lines[1].outlook->end->low_s, lines[0].outlook->end->low_s);
}

TEST_F(QueueTest, TheOutlookOfAnEntryRestsOnTheRunThatHasJustEnded) {
  const auto a = add(with_lines("a", 4)), b = add(with_lines("b", 4)), c = add(with_lines("c", 4));
  const auto rests_on = [&](std::int64_t runs) {
    const auto outlook = cell->queue.get(c.entry.id)->outlook;
    return outlook && outlook->run.runs == runs;
  };
  cell.until([&] { return rests_on(0); }, 600);
  until(a, QueueState::done);
  cell.until([&] { return rests_on(1); }, 60);
  EXPECT_EQ(state_of(c), QueueState::waiting);
  EXPECT_NE(state_of(b), QueueState::done);
}

}  // namespace
}  // namespace driftwise::tests
