// What happens to diagnoses and improvements, by cursor: every change once, whoever made it.

#include <set>

#include "tests/unit/storage/store_fixture.h"

namespace driftwise::storage {
namespace {

class JobChangesTest : public StoreTest {
 protected:
  DiagnosisId diagnosis() {
    DiagnosisRecord record;
    record.baseline = "q ~ x";
    record.created = at_s(1).utc;
    return store->diagnoses().add_diagnosis(record).value().id;
  }
  ImprovementId improvement() {
    ImprovementRecord record;
    record.formula = "q ~ x";
    record.created = at_s(1).utc;
    return store->improvements().add_improvement(record).value().id;
  }
  void end(DiagnosisId id) {
    ASSERT_TRUE(store->diagnoses().end_diagnosis(id, {JobState::done, "", "", "{}", "", {}}));
  }
  RecordCursor now() { return store->records().newest().value(); }
  RecordPage since(const RecordCursor& then) {
    return store->records().records(then, now(), 1000).value();
  }
};

TEST_F(JobChangesTest, EveryStepOfADiagnosisIsNews) {
  auto then = now();
  const DiagnosisId id = diagnosis();
  ASSERT_EQ(since(then).diagnoses.size(), 1U);
  EXPECT_EQ(since(then).diagnoses[0].state, JobState::running);
  then = now();
  end(id);
  ASSERT_EQ(since(then).diagnoses.size(), 1U);
  EXPECT_EQ(since(then).diagnoses[0].id, id);
  EXPECT_EQ(since(then).diagnoses[0].state, JobState::done);
  then = now();
  NewExtension made;
  made.diagnosis = id;
  made.findings = {1};
  made.at = at_s(2);
  ASSERT_TRUE(store->extensions().accept(made));
  EXPECT_EQ(since(then).diagnoses.size(), 1U) << "accepted";
  then = now();
  ASSERT_TRUE(store->extensions().undo_extension(id, at_s(3), "ada", ""));
  EXPECT_EQ(since(then).diagnoses.size(), 1U) << "undone";
  EXPECT_TRUE(since(now()).diagnoses.empty());
}

TEST_F(JobChangesTest, EveryTurnOfAnImprovementIsNews) {
  const ImprovementId id = improvement();
  auto then = now();
  ImprovementTurn turn;
  turn.number = 1;
  ASSERT_TRUE(store->improvements().put_turn(id, turn));
  ASSERT_EQ(since(then).improvements.size(), 1U);
  EXPECT_EQ(since(then).improvements[0].turns, 1);
  then = now();
  turn.what = "now with its gain";
  ASSERT_TRUE(store->improvements().put_turn(id, turn));
  ASSERT_EQ(since(then).improvements.size(), 1U);
  EXPECT_EQ(since(then).improvements[0].turns, 1);
  then = now();
  ASSERT_TRUE(
      store->improvements().end_improvement(id, JobState::cancelled, "by ada", at_s(4).utc));
  ASSERT_EQ(since(then).improvements.size(), 1U);
  EXPECT_EQ(since(then).improvements[0].state, JobState::cancelled);
  EXPECT_EQ(since(then).improvements[0].reason, "by ada");
}

TEST_F(JobChangesTest, WhatTheNextStartFindsUnfinishedIsNewsForWhoSlept) {
  const DiagnosisId id = diagnosis();
  const ImprovementId loop = improvement();
  const auto then = now();
  reopen();
  ASSERT_EQ(store->diagnoses().fail_unfinished("the daemon ended while it ran", at_s(9).utc), 2);
  const auto page = since(then);
  ASSERT_EQ(page.diagnoses.size(), 1U);
  EXPECT_EQ(page.diagnoses[0].id, id);
  EXPECT_EQ(page.diagnoses[0].state, JobState::failed);
  EXPECT_EQ(page.diagnoses[0].reason, "the daemon ended while it ran");
  ASSERT_EQ(page.improvements.size(), 1U);
  EXPECT_EQ(page.improvements[0].id, loop);
}

TEST_F(JobChangesTest, SmallPagesGiveAllOfThem) {
  std::vector<DiagnosisId> made;
  for (int i = 0; i < 7; ++i) {
    made.push_back(diagnosis());
    improvement();
    end(made.back());
  }
  for (const int limit : {1, 2, 5, 100}) {
    std::set<std::int64_t> seen;
    RecordCursor at;
    for (int pages = 0; at != now(); ++pages) {
      ASSERT_LT(pages, 100);
      const auto page = store->records().records(at, now(), limit).value();
      for (const auto& one : page.diagnoses)
        if (one.state == JobState::done) seen.insert(one.id.value);
      ASSERT_NE(page.to, at);
      at = page.to;
    }
    EXPECT_EQ(seen.size(), made.size()) << limit;
  }
}

}  // namespace
}  // namespace driftwise::storage
