// Follow-ups and alarms of the queue while the disk is full.

#include "tests/unit/application/queue/queue_without_room.h"

#include <gmock/gmock.h>

#include "tests/unit/application/queue/queue_cell.h"

namespace driftwise::tests {
namespace {

// There before the cell that holds them.
struct OwnsRefusals {
  QueueRefusals refusals;
};

class QueueWithoutRoomTest : protected OwnsRefusals, public QueueTest {
 protected:
  QueueWithoutRoomTest() : QueueTest(queue_without_room(refusals)) {}

  // An entry whose run is done, after a minute in which the result of its follow-up has no room.
  QueueLine refused_after(const std::vector<std::string>& follow_ups) {
    auto d = draft("night");
    d.trajectory_text = lines_of(4, {-4, -2, 1, 3}, true);
    d.follow_ups = follow_ups;
    const auto line = add(d);
    until(line, QueueState::following);
    refusals.of_changes = true;
    cell.pass(60);
    EXPECT_GT(refusals.changes, 3) << "it is tried again and again";
    EXPECT_EQ(state_of(line), QueueState::following);
    return line;
  }
  std::size_t models() { return cell.await(cell->models.list())->size(); }
  std::ptrdiff_t pages() {
    const auto alarms = cell.await(cell->alarms.list(true, 100));
    return std::ranges::count(*alarms, "queue.done", &AlarmRecord::kind);
  }
};

TEST_F(QueueWithoutRoomTest, AFitWhoseResultIsRefusedIsMadeOnce) {
  const auto line = refused_after({"fit:q ~ x"});
  EXPECT_EQ(models(), 1U);
  refusals.of_changes = false;
  until(line, QueueState::done);
  EXPECT_EQ(models(), 1U);
  ASSERT_EQ(look(line).results.size(), 1U);
  EXPECT_TRUE(look(line).results[0].model);
}

TEST_F(QueueWithoutRoomTest, PeopleAreNotifiedOnceWhenItsResultIsOnRecord) {
  const auto line = refused_after({"notify"});
  EXPECT_EQ(pages(), 0);
  refusals.of_changes = false;
  until(line, QueueState::done);
  cell.pass(60);
  EXPECT_EQ(pages(), 1);
}

// A fit of a channel without values.
TEST_F(QueueWithoutRoomTest, AFollowUpThatFailedIsToldOnceWhenItsResultIsOnRecord) {
  const auto line = refused_after({"fit:q ~ x + pressure"});
  EXPECT_TRUE(cell.events_named("queue.follow_up_failed").empty());
  refusals.of_changes = false;
  until(line, QueueState::done);
  EXPECT_EQ(cell.events_named("queue.follow_up_failed").size(), 1U);
}

TEST_F(QueueWithoutRoomTest, AListOfAlarmsLeavesOutWhatIsOverBeforeWhatHolds) {
  auto broken = draft("broken");
  broken.compensate = true;
  broken.trajectory_text = "x_mm\n0\n1\n0\n";  // no model serves when it starts
  broken.on_failure = OnFailure::set_aside;
  until(add(broken), QueueState::set_aside);
  cell.pass(10);
  ASSERT_EQ(cell.alarms_of("queue.set_aside").size(), 1U);
  refusals.of_alarms = true;
  auto night = draft("night");
  night.follow_ups = {"notify"};
  until(add(night), QueueState::done);
  cell.pass(5);
  const auto all = cell.await(cell->alarms.list(false, 100));
  ASSERT_TRUE(all);
  ASSERT_NE(all->front().cleared.utc_ns, 0) << "over at once, newer and not on record";
  const auto one = cell.await(cell->alarms.list(false, 1));
  ASSERT_EQ(one->size(), 1U);
  EXPECT_EQ(one->front().cleared.utc_ns, 0) << one->front().kind;
}

}  // namespace
}  // namespace driftwise::tests
