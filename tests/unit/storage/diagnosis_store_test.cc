// Diagnoses, what was made of them, and the loops: kept over a restart, and undone to the row.

#include "storage/diagnosis/diagnosis_store.h"

#include "tests/unit/storage/store_fixture.h"

namespace driftwise::storage {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class DiagnosisStoreTest : public StoreTest {
 protected:
  DiagnosisStoreTest() {
    for (int row = 0; row < 6; ++row)
      EXPECT_TRUE(store->points().commit(example_commit(run, datum, row)));
  }
  DiagnosisRecord wanted() const {
    DiagnosisRecord record;
    record.name = "after the move";
    record.runs = {run};
    record.baseline = "q ~ x";
    record.request_json = R"({"alpha":0.003})";
    record.created = at_s(100).utc;
    record.created_by = "ada";
    return record;
  }
  DiagnosisId one() { return store->diagnoses().add_diagnosis(wanted()).value().id; }
  DiagnosisId done() {
    const DiagnosisId id = one();
    EXPECT_TRUE(store->diagnoses().end_diagnosis(
        id, {JobState::done, "", "q ~ x + lag(t07, 1830 s)", R"({"verdict":"extended"})",
             std::string("\x00\x01rows", 6), at_s(160).utc}));
    return id;
  }
  NewExtension extension(DiagnosisId id) const {
    NewExtension made;
    made.diagnosis = id;
    made.findings = {1, 3};
    made.correction_json = R"({"schema":"driftwise.correction.v1"})";
    made.exclusions = {{0, run, true, {2, 3}, "outliers", {}, "", ""}};
    made.at = at_s(200);
    made.who = "ada";
    made.from = "ipv4:127.0.0.1:5020";
    return made;
  }
  std::vector<std::uint8_t> out_now() {
    return store->runs().dataset(std::vector{run}).value().excluded;
  }
};

TEST_F(DiagnosisStoreTest, KeepsADiagnosisWithItsRowsOverARestart) {
  const DiagnosisId id = done();
  reopen();
  const auto record = store->diagnoses().diagnosis(id).value();
  EXPECT_EQ(record.state, JobState::done);
  EXPECT_EQ(record.name, "after the move");
  EXPECT_THAT(record.runs, ElementsAre(run));
  EXPECT_EQ(record.extended, "q ~ x + lag(t07, 1830 s)");
  EXPECT_EQ(record.result_json, R"({"verdict":"extended"})");
  EXPECT_EQ(record.created, at_s(100).utc);
  EXPECT_EQ(record.ended, at_s(160).utc);
  EXPECT_EQ(store->diagnoses().diagnosis_rows(id).value(), std::string("\x00\x01rows", 6));
}

TEST_F(DiagnosisStoreTest, ListsTheNewestFirst) {
  const DiagnosisId first = done(), second = one();
  const auto all = store->diagnoses().diagnoses(0).value();
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].id, second);
  EXPECT_EQ(all[1].id, first);
  EXPECT_EQ(store->diagnoses().diagnoses(1)->size(), 1u);
  EXPECT_EQ(store->diagnoses().diagnosis(DiagnosisId{99}).error().reason, "NO_SUCH_DIAGNOSIS");
}

TEST_F(DiagnosisStoreTest, TheFirstEndStands) {
  const DiagnosisId id = one();
  ASSERT_TRUE(store->diagnoses().end_diagnosis(
      id, {JobState::cancelled, "cancelled by ada", "", "", "", at_s(101).utc}));
  const auto late =
      store->diagnoses().end_diagnosis(id, {JobState::done, "", "", "{}", "", at_s(102).utc});
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().reason, "ALREADY_OVER");
  EXPECT_EQ(store->diagnoses().diagnosis(id)->state, JobState::cancelled);
}

TEST_F(DiagnosisStoreTest, WhatRanWhenTheDaemonEndedHasFailedWithTheReason) {
  const DiagnosisId ended = done(), running = one();
  ImprovementRecord loop;
  loop.trajectory_name = "plan.csv";
  const auto improvement = store->improvements().add_improvement(loop).value();
  reopen();
  EXPECT_EQ(store->diagnoses().fail_unfinished("the daemon ended", at_s(300).utc).value(), 2);
  EXPECT_EQ(store->diagnoses().diagnosis(running)->state, JobState::failed);
  EXPECT_EQ(store->diagnoses().diagnosis(running)->reason, "the daemon ended");
  EXPECT_EQ(store->diagnoses().diagnosis(ended)->state, JobState::done);
  EXPECT_EQ(store->improvements().improvement(improvement.id)->state, JobState::failed);
  EXPECT_EQ(store->diagnoses().fail_unfinished("again", at_s(301).utc).value(), 0);
}

TEST_F(DiagnosisStoreTest, AnExtensionKeepsRowsOutAndUndoingPutsThoseBackOnly) {
  const DiagnosisId id = done();
  ASSERT_TRUE(store->remarks().exclude({0, run, true, {3}, "door opened", at_s(150), "bob", ""}));
  const auto made = store->extensions().accept(extension(id)).value();
  EXPECT_THAT(made.findings, ElementsAre(1, 3));
  ASSERT_TRUE(made.correction);
  ASSERT_EQ(made.excluded.size(), 1u);
  EXPECT_THAT(made.excluded[0].rows, ElementsAre(2));  // 3 was out before
  EXPECT_THAT(out_now(), ElementsAre(0, 0, 1, 1, 0, 0));
  EXPECT_TRUE(store->extensions().corrections()->at(0).in_force());

  const auto again = store->extensions().accept(extension(id));
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().reason, "EXTENSION_STANDS");

  const auto undone = store->extensions().undo_extension(id, at_s(400), "bob", "").value();
  EXPECT_FALSE(undone.stands());
  EXPECT_EQ(undone.undone_by, "bob");
  EXPECT_THAT(out_now(), ElementsAre(0, 0, 0, 1, 0, 0));
  const auto correction = store->extensions().corrections()->at(0);
  EXPECT_FALSE(correction.in_force());
  EXPECT_EQ(correction.ended, at_s(400).utc);
  EXPECT_EQ(store->extensions().undo_extension(id, at_s(401), "bob", "").error().reason,
            "NO_EXTENSION");
  EXPECT_TRUE(store->extensions().accept(extension(id)));  // and once more
}

TEST_F(DiagnosisStoreTest, RowsStayOutUntilTheLastExtensionThatNamesThemIsUndone) {
  const DiagnosisId first = done(), second = done();
  ASSERT_TRUE(store->extensions().accept(extension(first)));  // rows 2 and 3
  auto other = extension(second);
  other.exclusions[0].rows = {3, 4};
  ASSERT_TRUE(store->extensions().accept(other));
  EXPECT_THAT(out_now(), ElementsAre(0, 0, 1, 1, 1, 0));
  ASSERT_TRUE(store->extensions().undo_extension(first, at_s(300), "ada", ""));
  EXPECT_THAT(out_now(), ElementsAre(0, 0, 0, 1, 1, 0)) << "row 3 is the second's too";
  ASSERT_TRUE(store->extensions().undo_extension(second, at_s(301), "ada", ""));
  EXPECT_TRUE(std::ranges::none_of(out_now(), [](auto out) { return out != 0; }));
}

TEST_F(DiagnosisStoreTest, AnExtensionWithARowThatIsNotThereLeavesNothing) {
  const DiagnosisId id = done();
  auto bad = extension(id);
  bad.exclusions[0].rows = {2, 77};
  const auto refused = store->extensions().accept(bad);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("row 78"));
  EXPECT_THAT(*store->extensions().corrections(), IsEmpty());
  EXPECT_FALSE(store->extensions().extension(id).value());
  EXPECT_TRUE(out_now().empty());
}

TEST_F(DiagnosisStoreTest, KeepsAnImprovementTurnByTurn) {
  ImprovementRecord wanted;
  wanted.trajectory_name = "plan.csv";
  wanted.trajectory_text = "q1_mm\n0\n";
  wanted.formula = "q ~ x";
  wanted.max_turns = 3;
  wanted.budget_s = 7200;
  wanted.promotes = false;
  wanted.request_id = "r1";
  wanted.created = at_s(500).utc;
  wanted.created_by = "ada";
  const auto made = store->improvements().add_improvement(wanted).value();
  EXPECT_EQ(store->improvements().add_improvement(wanted)->id, made.id);  // the same request again
  ImprovementTurn turn;
  turn.number = 1;
  turn.runs = {run};
  turn.what = "measured";
  turn.started = at_s(501).utc;
  ASSERT_TRUE(store->improvements().put_turn(made.id, turn));
  turn.what = "measured, and found a lag";
  turn.diagnosis = done();
  const ErrorFigures before{.mean = 9, .u90 = 41, .a90 = 44}, promised{.u90 = 12.5, .a90 = 12.5},
      fresh_before{.mean = -8, .u90 = 43, .a90 = 45}, fresh{.mean = 1, .u90 = 13, .a90 = 13.1};
  turn.gains = {{"q1", "nm", before, promised, {}, {}},
                {"q2", "nm", before, {}, fresh_before, fresh}};
  turn.ended = at_s(600).utc;
  ASSERT_TRUE(store->improvements().put_turn(made.id, turn));
  ASSERT_TRUE(
      store->improvements().end_improvement(made.id, JobState::done, "enough", at_s(601).utc));
  reopen();
  const auto record = store->improvements().improvements(0)->at(0);
  EXPECT_EQ(record.state, JobState::done);
  EXPECT_EQ(record.reason, "enough");
  EXPECT_FALSE(record.promotes);
  ASSERT_EQ(record.turns.size(), 1u);
  EXPECT_EQ(record.turns[0].what, "measured, and found a lag");
  EXPECT_THAT(record.turns[0].runs, ElementsAre(run));
  ASSERT_EQ(record.turns[0].gains.size(), 2u);
  EXPECT_EQ(record.turns[0].gains[0].before, before);
  EXPECT_EQ(record.turns[0].gains[0].predicted, promised);
  EXPECT_EQ(record.turns[0].gains[0].measured, std::nullopt);
  EXPECT_EQ(record.turns[0].gains[1].measured_before, fresh_before);
  EXPECT_EQ(record.turns[0].gains[1].measured, fresh);
}

// What 0.1.0 left gets the new tables, and a diagnosis of its run finds a place in them.
TEST(DiagnosisSchema, ADatabaseOfVersion1TakesADiagnosis) {
  const TemporaryFolder folder;
  const auto store = open_store(copy_of_version_1_cell(folder));
  DiagnosisRecord wanted;
  wanted.runs = {RunId{1}};
  wanted.model = ModelId{1};
  const auto made = store->diagnoses().add_diagnosis(wanted);
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_EQ(store->diagnoses().diagnosis(made->id)->model, ModelId{1});
}

}  // namespace
}  // namespace driftwise::storage
