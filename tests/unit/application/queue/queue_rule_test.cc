// Which entry starts now, and why the others wait, as sentences.

#include "server/application/queue/queue_rule.h"

#include <gtest/gtest.h>

#include <functional>

namespace driftwise::application {
namespace {

constexpr std::int64_t kHour_ns = 3'600'000'000'000;

QueueEntry queued(std::int64_t id, const std::string& name, int priority = 0) {
  QueueEntry e;
  e.id = {id};
  e.place = id;
  e.name = name;
  e.priority = priority;
  return e;
}

struct ExpectedTurn {
  std::int64_t starts;  // 0: none
  std::map<std::int64_t, std::string> waits;
};
struct QueueRow {
  const char* name;
  std::vector<QueueEntry> entries;
  QueueSituation situation;
  ExpectedTurn expected;
};

QueueEntry changed(QueueEntry e, const std::function<void(QueueEntry&)>& change) {
  change(e);
  return e;
}

std::vector<QueueRow> queue_rows() {
  const auto in = [](QueueState state) { return [state](QueueEntry& e) { e.state = state; }; };
  QueueSituation held;
  held.hold = {true, "ada", "stopped by ada", {}};
  QueueSituation busy;
  busy.busy = "ada holds the lease to move until 2026-11-22T10:00:00Z";
  QueueSituation cold;
  cold.conditions[{1}] = {false, "t12_degC below 20.5 degC for 30 min: 21.3 now"};
  QueueSituation met;
  met.conditions[{1}] = {true, "t12_degC below 20.5 degC: 20.1 now"};
  const auto on_t12 = [](QueueEntry& e) { e.condition = "t12_degC < 20.5 degC for 30 min"; };
  const auto after_one = [](QueueEntry& e) { e.after = QueueEntryId{1}; };
  const auto failed_fit = [](QueueEntry& e) {
    e.state = QueueState::done;
    e.results = {{0, false, "the fit failed"}};
  };
  return {
      {"first_of_two",
       {queued(1, "a"), queued(2, "b")},
       {},
       {1, {{2, "waits for its turn after entry 1 'a'"}}}},
      {"higher_priority_first",
       {queued(1, "a"), queued(2, "b", 5)},
       {},
       {2, {{1, "waits for its turn after entry 2 'b'"}}}},
      {"lower_place_first",
       {changed(queued(1, "a"), [](QueueEntry& e) { e.place = 9; }), queued(2, "b")},
       {},
       {2, {{1, "waits for its turn after entry 2 'b'"}}}},
      {"held",
       {queued(1, "a")},
       held,
       {0, {{1, "waits for a release of the queue, which is held: stopped by ada"}}}},
      {"somebody_holds_the_lease",
       {queued(1, "a"), queued(2, "b")},
       busy,
       {0,
        {{1, "waits: ada holds the lease to move until 2026-11-22T10:00:00Z"},
         {2, "waits for its turn after entry 1 'a'"}}}},
      {"one_runs",
       {changed(queued(1, "a"), in(QueueState::running)), queued(2, "b")},
       {},
       {0, {{2, "waits until entry 1 'a' is over"}}}},
      {"what_follows_a_run_lets_the_next_start",
       {changed(queued(1, "a"), in(QueueState::following)), queued(2, "b")},
       {},
       {2, {}}},
      {"not_before",
       {changed(queued(1, "a"), [](QueueEntry& e) { e.not_before = {kHour_ns}; }), queued(2, "b")},
       {},
       {2, {{1, "waits until 1970-01-01T01:00:00Z"}}}},
      {"condition_not_looked_at",
       {changed(queued(1, "a"), on_t12)},
       {},
       {0, {{1, "waits for t12_degC < 20.5 degC for 30 min: not looked at yet"}}}},
      {"condition_lets_others_pass",
       {changed(queued(1, "a"), on_t12), queued(2, "b")},
       cold,
       {2, {{1, "waits for t12_degC below 20.5 degC for 30 min: 21.3 now"}}}},
      {"condition_met",
       {changed(queued(1, "a"), on_t12), queued(2, "b")},
       met,
       {1, {{2, "waits for its turn after entry 1 'a'"}}}},
      {"after_one_that_waits",
       {changed(queued(1, "a"), [](QueueEntry& e) { e.not_before = {kHour_ns}; }),
        changed(queued(2, "b"), after_one)},
       {},
       {0,
        {{1, "waits until 1970-01-01T01:00:00Z"},
         {2, "waits until entry 1 'a' is accepted: that one waits"}}}},
      {"after_one_that_runs",
       {changed(queued(1, "a"), in(QueueState::running)), changed(queued(2, "b"), after_one)},
       {},
       {0, {{2, "waits until entry 1 'a' is accepted: that one is running"}}}},
      {"after_one_accepted",
       {changed(queued(1, "a"), in(QueueState::done)), changed(queued(2, "b"), after_one)},
       {},
       {2, {}}},
      {"after_one_not_accepted",
       {changed(queued(1, "a"), failed_fit), changed(queued(2, "b"), after_one)},
       {},
       {0,
        {{2,
          "waits for entry 1 'a', which was not accepted: something that followed its run failed: "
          "change or remove this one"}}}},
      {"after_one_set_aside",
       {changed(queued(1, "a"), in(QueueState::set_aside)), changed(queued(2, "b"), after_one)},
       {},
       {0,
        {{2,
          "waits for entry 1 'a', which was set aside: move that one back, or change this one"}}}},
      {"after_one_removed",
       {changed(queued(1, "a"), in(QueueState::removed)), changed(queued(2, "b"), after_one)},
       {},
       {0, {{2, "waits for entry 1 'a', which was removed: change or remove this one"}}}},
  };
}

class QueueRule : public testing::TestWithParam<QueueRow> {};

TEST_P(QueueRule, SaysWhoStartsAndWhyTheOthersWait) {
  auto situation = GetParam().situation;
  situation.entries = &GetParam().entries;
  const auto turn = decide_turn(situation);
  EXPECT_EQ(turn.starts ? turn.starts->value : 0, GetParam().expected.starts);
  std::map<std::int64_t, std::string> waits;
  for (const auto& [id, why] : turn.waits) waits[id.value] = why;
  EXPECT_EQ(waits, GetParam().expected.waits);
}

INSTANTIATE_TEST_SUITE_P(Table, QueueRule, testing::ValuesIn(queue_rows()),
                         [](const auto& row) { return std::string(row.param.name); });

TEST(QueueDependency, RefusesACircleAndAnEntryThatIsNotThere) {
  std::vector<QueueEntry> entries = {queued(1, "a"), queued(2, "b"), queued(3, "c")};
  entries[1].after = QueueEntryId{1};
  entries[2].after = QueueEntryId{2};
  EXPECT_TRUE(check_dependency(entries, {3}, {2}));
  EXPECT_EQ(check_dependency(entries, {1}, {1}).error().reason, "QUEUE_CYCLE");
  const auto circle = check_dependency(entries, {1}, {3});
  ASSERT_FALSE(circle);
  EXPECT_EQ(circle.error().message, "entry 1 would wait for itself: 1 after 3 after 2 after 1");
  EXPECT_EQ(check_dependency(entries, {3}, {9}).error().reason, "NO_SUCH_QUEUE_ENTRY");
}

std::vector<std::string> kinds_of(const QueueRecord& record) {
  std::vector<std::string> kinds;
  for (const auto& one : queue_alarms(record)) kinds.push_back(one.kind + " of " + one.subject);
  return kinds;
}

TEST(QueueAlarms, StandForWhatTheStoredStateAsksOfAPerson) {
  using Kinds = std::vector<std::string>;
  const auto failed = changed(queued(1, "a"), [](QueueEntry& e) { e.reason = "run 5 failed"; });
  const auto aside = changed(failed, [](QueueEntry& e) { e.state = QueueState::set_aside; });
  const QueueHold by_failure{true, "", "entry 1 'a': run 5 failed", {}};
  const QueueHold by_stop{true, "ada", "stopped by ada", {}};
  const QueueHold by_person{true, "ada", "held by ada: holidays", {}};
  EXPECT_EQ(kinds_of({{failed, queued(2, "b")}, by_failure}),
            Kinds{"queue.failed of queue entry 1"});
  EXPECT_EQ(kinds_of({{queued(2, "b")}, by_failure}), Kinds{"queue.held of queue"})
      << "the failed one was removed";
  EXPECT_EQ(kinds_of({{queued(2, "b")}, by_stop}), Kinds{"queue.held of queue"});
  EXPECT_EQ(kinds_of({{}, by_stop}), Kinds{}) << "nothing waits";
  EXPECT_EQ(kinds_of({{queued(2, "b")}, by_person}), Kinds{}) << "a person knows";
  EXPECT_EQ(kinds_of({{failed}, QueueHold{}}), Kinds{}) << "released: it is tried again";
  EXPECT_EQ(kinds_of({{aside, queued(2, "b")}, QueueHold{}}),
            Kinds{"queue.set_aside of queue entry 1"});
}

}  // namespace
}  // namespace driftwise::application
