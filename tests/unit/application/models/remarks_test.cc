// Rows kept out of fits: the fit of the runs and the fit of their export stay one and the same.

#include <gmock/gmock.h>

#include "server/formats/csv/dataset_csv.h"
#include "server/formats/model/model_json.h"
#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class Remarks : public testing::Test {
 protected:
  Remarks() { run = cell.finish_run_of(lines_of(6, {2, -3, 1, -1}, true)); }

  Result<application::ExclusionState> exclude(std::vector<std::int64_t> rows, bool out = true) {
    ExclusionRecord wanted;
    wanted.run = run;
    wanted.excluded = out;
    wanted.rows = std::move(rows);
    wanted.reason = "someone leaned on the table";
    return cell.await(cell->annotations.exclude_rows(cell.ada, wanted));
  }
  calibration::Model fitted(application::FitRequest request) {
    request.formula = "q ~ x";
    const auto record = cell.await(cell->models.fit(cell.ada, std::move(request)));
    if (!record) throw std::runtime_error(record.error().message);
    return *formats::read_model_json(record->json);
  }
  calibration::Model fit_of_run() {
    application::FitRequest request;
    request.runs = {run};
    return fitted(request);
  }

  struct CellWithAVerb : CellInMemory {
    using CellInMemory::CellInMemory;
    RunId finish_run_of(const std::string& csv) {
      const auto begun = begin_run(csv);
      finish_run();
      return begun.id;
    }
  };
  Folder folder;
  SmallWorld world;
  CellWithAVerb cell{world, small_cell(folder / "cell.sqlite"), kSqlite};
  RunId run;
};

TEST_F(Remarks, KeepRowsOutOfTheFitOfTheRunAndOfItsExportAlike) {
  const auto before = fit_of_run();
  const auto state = exclude({3, 8, 9});
  ASSERT_TRUE(state) << state.error().message;
  EXPECT_THAT(state->rows, ElementsAre(3, 8, 9));
  const auto after = fit_of_run();
  EXPECT_EQ(after.lineage.rows_excluded, 3);
  EXPECT_EQ(after.lineage.exclusions_hash, state->hash);
  EXPECT_EQ(after.lineage.rows_calibration + after.lineage.rows_validation + 3,
            before.lineage.rows_calibration + before.lineage.rows_validation);

  application::FitRequest of_file;
  of_file.csv = *cell.await(cell->datasets.export_csv({run}, false));
  const auto offline = fitted(of_file);
  EXPECT_EQ(offline.outputs[0].coefficients, after.outputs[0].coefficients);
  EXPECT_EQ(offline.lineage.exclusions_hash, after.lineage.exclusions_hash);
  EXPECT_EQ(offline.lineage.dataset_hash != before.lineage.dataset_hash, true);
  of_file.csv = *cell.await(cell->datasets.export_csv({run}, true));
  EXPECT_THAT(of_file.csv, testing::Not(HasSubstr("excluded")));
  EXPECT_EQ(fitted(of_file).outputs[0].coefficients, after.outputs[0].coefficients);

  ASSERT_TRUE(exclude({3, 8, 9}, false));
  EXPECT_EQ(formats::model_hash(fit_of_run()), formats::model_hash(before));  // as if never out
}

TEST_F(Remarks, SayWhoKeptWhatOutAndWhy) {
  ASSERT_TRUE(exclude({3, 8, 9}));
  ASSERT_TRUE(exclude({3, 8, 9}));  // again: nothing changes, nothing is said
  ASSERT_TRUE(exclude({8}, false));
  EXPECT_THAT(
      cell.events_named("data.excluded"),
      ElementsAre("ada keeps rows 4,9-10 of run 1 out of fits: someone leaned on the table"));
  EXPECT_THAT(cell.events_named("data.restored"),
              ElementsAre("ada puts rows 9 of run 1 back into fits: someone leaned on the table"));
  const auto state = cell.await(cell->annotations.exclusions(run));
  ASSERT_TRUE(state);
  EXPECT_THAT(state->rows, ElementsAre(3, 9));
  EXPECT_EQ(state->history.size(), 2u);
  EXPECT_EQ(state->history[0].from, cell.ada.peer);
}

TEST_F(Remarks, RefuseRowsThatAreNotThere) {
  EXPECT_EQ(exclude({3, 999}).error().reason, "NO_SUCH_ROW");
  EXPECT_TRUE(cell.await(cell->annotations.exclusions(run))->rows.empty());
  EXPECT_EQ(cell.await(cell->annotations.exclusions(RunId{9})).error().reason, "NO_SUCH_RUN");
}

TEST_F(Remarks, KeepNotes) {
  ASSERT_TRUE(cell.await(
      cell->annotations.add_note(cell.ada, {.run = run, .row = 2, .model = {}}, "a cough")));
  const auto notes = cell.await(cell.read([run = run](Store& store) {
    return store.remarks().notes({.run = run, .row = {}, .model = {}});
  }));
  ASSERT_TRUE(notes);
  EXPECT_EQ(notes->at(0).text, "a cough");
  EXPECT_EQ(notes->at(0).who, "ada");
  EXPECT_THAT(cell.events_named("note.added"), ElementsAre("ada on run 1, row 3: a cough"));
}

TEST_F(Remarks, ImportOfTheSameRequestTwiceIsOneRun) {
  const std::string csv = *cell.await(cell->datasets.export_csv({run}, false));
  const auto first = cell.await(cell->datasets.import_csv(cell.ada, "d.csv", csv, "7d0f"));
  cell.pass(1);
  const auto again = cell.await(cell->datasets.import_csv(cell.ada, "d.csv", csv, "7d0f"));
  ASSERT_TRUE(first && again);
  EXPECT_EQ(first->id, again->id);
  EXPECT_EQ(cell.events_named("data.imported").size(), 1u);
  const auto other = cell.await(cell->datasets.import_csv(cell.ada, "d.csv", csv + "\n", "7d0f"));
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().reason, "REQUEST_ID_REUSED");
  EXPECT_NE(cell.await(cell->datasets.import_csv(cell.ada, "d.csv", csv, ""))->id, first->id);
}

}  // namespace
}  // namespace driftwise::tests
