// The queue of campaigns, and metadata of runs.

#include "tests/unit/storage/store_fixture.h"

namespace driftwise::storage {
namespace {

class QueueStoreTest : public StoreTest {
 protected:
  static QueueEntry example_entry(std::int64_t id) {
    QueueEntry e;
    e.id = {id};
    e.place = 3;
    e.name = "night";
    e.trajectory_name = "night.csv";
    e.trajectory_text = "q1_mm\n0\n";
    e.rows = 1;
    e.rules_json = "{}";
    e.metadata = {{"sample", "A12"}, {"tool", "probe"}};
    e.priority = 2;
    e.not_before = {17};
    e.condition = "t12_degC < 20.5 degC";
    e.on_failure = OnFailure::set_aside;
    e.repeat_every_s = 43'200;
    e.follow_ups = {"fit:q ~ x", "notify"};
    e.request_id = "7d0f";
    e.created = at_s(1).utc;
    e.created_by = "ada";
    e.created_from = "ipv4:127.0.0.1:1";
    return e;
  }
  void put(QueueEntry e) {
    QueueChange change;
    change.put = {std::move(e)};
    ASSERT_TRUE(store->queue().change_queue(change));
  }
  QueueRecord read() { return store->queue().queue(10).value(); }
};

TEST_F(QueueStoreTest, KeepsAnEntryWhole) {
  auto wanted = example_entry(1);
  wanted.results = {{0, false, "the fit failed", {}, {}, at_s(4).utc}};
  put(wanted);
  reopen();
  const auto record = read();
  ASSERT_EQ(record.entries.size(), 1u);
  const auto& e = record.entries[0];
  EXPECT_EQ(e.id.value, 1);
  EXPECT_EQ(e.place, 3);
  EXPECT_EQ(e.state, QueueState::waiting);
  EXPECT_EQ(e.trajectory_text, wanted.trajectory_text);
  EXPECT_EQ(e.metadata, wanted.metadata);
  EXPECT_EQ(e.priority, 2);
  EXPECT_EQ(e.not_before.ns, 17);
  EXPECT_EQ(e.condition, wanted.condition);
  EXPECT_EQ(e.on_failure, OnFailure::set_aside);
  EXPECT_EQ(e.repeat_every_s, 43'200);
  EXPECT_EQ(e.follow_ups, wanted.follow_ups);
  EXPECT_EQ(e.created_by, "ada");
  ASSERT_EQ(e.results.size(), 1u);
  EXPECT_EQ(e.results[0].text, "the fit failed");
  EXPECT_FALSE(e.results[0].good);
  EXPECT_FALSE(record.hold.held);
}

TEST_F(QueueStoreTest, AnEntryRunsFromTheTransactionThatMakesItsRun) {
  put(example_entry(1));
  auto wanted = example_run("night");
  wanted.queue_entry = QueueEntryId{1};
  wanted.metadata = {{"sample", "A12"}};
  const auto begun = store->runs().create_run(wanted).value();
  EXPECT_EQ(begun.queue_entry, QueueEntryId{1});
  EXPECT_EQ(begun.metadata, wanted.metadata);
  const auto e = read().entries.at(0);
  EXPECT_EQ(e.state, QueueState::running);
  EXPECT_EQ(e.run, begun.id);
  EXPECT_EQ(e.begun, wanted.created.utc);
}

TEST_F(QueueStoreTest, AStopHoldsItInTheSameTransaction) {
  StopRecord stop;
  stop.controller = "axis";
  stop.who = "ada";
  stop.cause = "stopped by ada";
  stop.asked = at_s(5);
  stop.presses = 1;
  ASSERT_TRUE(store->stops().keep(std::vector{stop}));
  const auto hold = read().hold;
  EXPECT_TRUE(hold.held);
  EXPECT_EQ(hold.who, "ada");
  EXPECT_EQ(hold.why, "stopped by ada");
  QueueChange release;
  release.hold = QueueHold{};
  ASSERT_TRUE(store->queue().change_queue(release));
  EXPECT_FALSE(read().hold.held);
}

TEST_F(QueueStoreTest, OneThatIsOverLeavesItsTextToTheRun) {
  auto over = example_entry(1);
  over.state = QueueState::done;
  put(over);
  for (std::int64_t id = 2; id < 20; ++id) {
    auto later = example_entry(id);
    later.state = QueueState::removed;
    put(later);
  }
  auto open = example_entry(20);
  open.after = QueueEntryId{1};
  put(open);
  const auto record = read();
  ASSERT_EQ(record.entries.size(), 11u);  // the newest ten, and the one that is waited for
  EXPECT_EQ(record.entries.front().id.value, 1);
  EXPECT_EQ(record.entries.front().trajectory_text, "");
  EXPECT_EQ(record.entries.back().trajectory_text, "q1_mm\n0\n");
}

TEST_F(QueueStoreTest, MetadataIsSetRemovedAndSearched) {
  ASSERT_TRUE(store->metadata().tag(run, {{"sample", "A12"}, {"tool", "probe"}}, {}));
  const auto tagged = store->metadata().tag(run, {{"sample", "A13"}}, {"tool"}).value();
  EXPECT_EQ(tagged.metadata, (RunMetadata{{"sample", "A13"}}));
  store->runs().create_run(example_run("other")).value();
  EXPECT_EQ(store->metadata().find_runs({{"sample", "A13"}}, 0, 0)->size(), 1u);
  EXPECT_EQ(store->metadata().find_runs({{"sample", "A1"}}, 0, 0)->size(), 0u);
  EXPECT_EQ(store->metadata().find_runs({}, 0, 0)->size(), 2u);
  EXPECT_EQ(store->metadata().tag({99}, {}, {}).error().reason, "NO_SUCH_RUN");
}

}  // namespace
}  // namespace driftwise::storage
