#include "driftwise/v1/queue_service.grpc.pb.h"
#include "driftwise/v1/run_service.grpc.pb.h"
#include "tests/unit/rpc/rpc_fixture.h"

namespace driftwise::tests {
namespace {

using QueueStub = v1::QueueService::Stub;

class QueueServiceTest : public RpcTest {
 protected:
  void SetUp() override {
    RpcTest::SetUp();  // nothing starts by itself
    EXPECT_TRUE(ask(&QueueStub::HoldQueue, v1::HoldQueueRequest{}));
  }
  static v1::AddQueueEntryRequest an_entry() {
    v1::AddQueueEntryRequest request;
    request.set_name("night");
    request.set_trajectory_name("night.csv");
    request.set_trajectory_text("q1_mm\n0\n1\n0\n");
    return request;
  }
};

TEST_F(QueueServiceTest, AddsAnEntryAsItWasAskedFor) {
  auto request = an_entry();
  request.set_priority(3);
  request.mutable_not_before_time()->set_seconds(1'900'000'000);
  request.mutable_repeat_duration()->set_seconds(43'200);
  request.set_set_aside_on_failure(true);
  request.add_follow_ups("fit:q ~ x");
  auto& item = *request.add_metadata();
  item.set_key("sample");
  item.set_value("A12");
  const auto added = ask(&QueueStub::AddQueueEntry, request);
  ASSERT_TRUE(added) << added.error().message;
  v1::GetQueueEntryRequest wanted;
  wanted.set_entry_id(added->entry().id());
  const auto kept = ask(&QueueStub::GetQueueEntry, wanted);
  ASSERT_TRUE(kept);
  EXPECT_EQ(kept->trajectory_text(), request.trajectory_text());
  const auto& entry = kept->entry();
  EXPECT_EQ(entry.state(), v1::QueueEntry::STATE_WAITING);
  EXPECT_EQ(entry.waits_for(), "waits until 2030-03-17T17:46:40Z");
  EXPECT_EQ(entry.created_by(), "ada");
  EXPECT_EQ(entry.row_count(), 3);
  EXPECT_EQ(entry.priority(), 3);
  EXPECT_EQ(entry.not_before_time().seconds(), 1'900'000'000);
  EXPECT_EQ(entry.repeat_duration().seconds(), 43'200);
  EXPECT_TRUE(entry.set_aside_on_failure());
  EXPECT_EQ(entry.follow_ups(0), "fit:q ~ x");
  EXPECT_EQ(entry.metadata(0).value(), "A12");
}

TEST_F(QueueServiceTest, ChangesMovesAndRemoves) {
  const auto first = ask(&QueueStub::AddQueueEntry, an_entry())->entry().id();
  const auto second = ask(&QueueStub::AddQueueEntry, an_entry())->entry().id();
  v1::ChangeQueueEntryRequest change;
  change.set_entry_id(first);
  change.set_after_entry_id(second);
  ASSERT_TRUE(ask(&QueueStub::ChangeQueueEntry, change));
  change.set_entry_id(second);
  change.set_after_entry_id(first);
  EXPECT_THAT(ask(&QueueStub::ChangeQueueEntry, change),
              FailsWith(ErrorCode::failed_precondition, "QUEUE_CYCLE"));
  v1::MoveQueueEntryRequest move;
  move.set_entry_id(second);
  move.set_before_entry_id(0);
  ASSERT_TRUE(ask(&QueueStub::MoveQueueEntry, move));
  const auto listed = ask(&QueueStub::ListQueue, v1::ListQueueRequest{});
  ASSERT_TRUE(listed);
  ASSERT_EQ(listed->entries_size(), 2);
  EXPECT_EQ(listed->entries(0).id(), second);
  EXPECT_EQ(listed->hold().who(), "ada");
  v1::RemoveQueueEntryRequest remove;
  remove.set_entry_id(second);
  ASSERT_TRUE(ask(&QueueStub::RemoveQueueEntry, remove));
  EXPECT_THAT(ask(&QueueStub::MoveQueueEntry, move),
              FailsWith(ErrorCode::failed_precondition, "QUEUE_ENTRY_BEGUN"));
  ASSERT_TRUE(ask(&QueueStub::ReleaseQueue, v1::ReleaseQueueRequest{}));
  EXPECT_FALSE(ask(&QueueStub::ListQueue, v1::ListQueueRequest{})->has_hold());
}

TEST_F(QueueServiceTest, RefusesWhatCannotBe) {
  auto request = an_entry();
  request.set_priority(5000);
  EXPECT_THAT(ask(&QueueStub::AddQueueEntry, request),
              FailsWith(ErrorCode::invalid_argument, "BAD_NUMBER"));
  request = an_entry();
  request.mutable_not_before_time()->set_seconds(-1);
  EXPECT_THAT(ask(&QueueStub::AddQueueEntry, request),
              FailsWith(ErrorCode::invalid_argument, "BAD_TIME"));
  request = an_entry();
  request.set_condition("t99 < 20 degC");
  EXPECT_THAT(ask(&QueueStub::AddQueueEntry, request),
              FailsWith(ErrorCode::invalid_argument, "BAD_CONDITION"));
  request = an_entry();
  request.set_trajectory_text("");
  EXPECT_THAT(ask(&QueueStub::AddQueueEntry, request),
              FailsWith(ErrorCode::invalid_argument, "EMPTY_TRAJECTORY"));
  v1::GetQueueEntryRequest none;
  none.set_entry_id(7);
  EXPECT_THAT(ask(&QueueStub::GetQueueEntry, none),
              FailsWith(ErrorCode::not_found, "NO_SUCH_QUEUE_ENTRY"));
}

TEST_F(QueueServiceTest, TagsARunAndFindsItByItsMetadata) {
  const auto id = cell.add_run("weekend").value;
  cell.add_run("other");
  v1::TagRunRequest tag;
  tag.set_run_id(id);
  auto& item = *tag.add_set();
  item.set_key("sample");
  item.set_value("A12");
  const auto tagged = ask(&v1::RunService::Stub::TagRun, tag);
  ASSERT_TRUE(tagged) << tagged.error().message;
  EXPECT_EQ(tagged->run().metadata(0).value(), "A12");
  v1::ListRunsRequest list;
  *list.add_metadata() = item;
  const auto found = ask(&v1::RunService::Stub::ListRuns, list);
  ASSERT_TRUE(found);
  ASSERT_EQ(found->runs_size(), 1);
  EXPECT_EQ(found->runs(0).id(), id);
  tag.mutable_set(0)->set_value("");
  EXPECT_THAT(ask(&v1::RunService::Stub::TagRun, tag),
              FailsWith(ErrorCode::invalid_argument, "BAD_METADATA"));
}

}  // namespace
}  // namespace driftwise::tests
