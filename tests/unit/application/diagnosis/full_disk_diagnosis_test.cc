// Diagnoses and improvements whose end the database does not take: under way until it does.

#include <gmock/gmock.h>

#include "tests/unit/application/diagnosis/diagnosed_cell.h"
#include "tests/unit/application/diagnosis/full_for_ends.h"

namespace driftwise::tests {
namespace {

using testing::HasSubstr;

Result<dx::Diagnosis> finds_nothing(const Dataset&, const dx::DiagnoseOptions& options) {
  return diagnosis_with(options.baseline.formula, {});
}

class FullDiskDiagnosisTest : public testing::Test {
 protected:
  FullDiskDiagnosisTest()
      : cell(world, small_cell(folder / "cell.sqlite"), full_for_ends(refusals),
             {.begin = kWorldBegin, .diagnose = finds_nothing}) {}
  DiagnosisId begun() {
    cell.begin_run(lines_of(4, {-3, -1, 2, 4}, true));
    application::DiagnosisRequest request;
    request.runs = {cell.finish_run().id};
    request.baseline = "q ~ x";
    const auto view = cell.await(cell->diagnoses.create(cell.ada, request));
    if (!view) throw std::runtime_error(view.error().message);
    return view->record.id;
  }
  DiagnosisRecord look(DiagnosisId id) { return cell.await(cell->diagnoses.get(id))->record; }
  ImprovementRecord look(ImprovementId id) {
    return *cell.await(
        cell.read([id](Store& store) { return store.improvements().improvement(id); }));
  }
  ImprovementId improving() {
    application::ImproveRequest request;
    request.trajectory_text = lines_of(8, {-4, -2.5, -1, 1.5, 3, 4}, true);
    request.trajectory_name = "lines.csv";
    request.formula = "q ~ x";
    request.lease_token = cell.lease();
    const auto record = cell.await(cell->improvements.create(cell.ada, std::move(request)));
    if (!record) throw std::runtime_error(record.error().message);
    return record->id;
  }
  bool says(const std::string& what) { return !cell.events_named(what).empty(); }

  Folder folder;
  SmallWorld world;
  Refusals refusals;
  CellInMemory cell;
};

TEST_F(FullDiskDiagnosisTest, KeepsTheEndAndStoresItWhenThereIsRoomAgain) {
  refusals.of_ends = disk_full();
  std::vector<application::DiagnosisProgress> told;
  const auto watch = cell->diagnoses.watch(
      [&](const application::DiagnosisProgress& progress) { told.push_back(progress); });
  const auto id = begun();
  cell.until([&] { return refusals.ends >= 3; });
  EXPECT_EQ(look(id).state, JobState::running);
  EXPECT_EQ(told.back().state, JobState::running) << "what is said is on record";
  EXPECT_THAT(told.back().step, HasSubstr("waiting until the database takes it"));
  EXPECT_THAT(cell.events_named("diagnosis.trouble").at(0), HasSubstr("the disk is full"));
  EXPECT_FALSE(says("diagnosis.done"));
  refusals.of_ends.reset();
  cell.pass(6);
  EXPECT_EQ(look(id).state, JobState::done);
  EXPECT_TRUE(cell.await(cell->diagnoses.get(id))->found);
  EXPECT_EQ(told.back().state, JobState::done);
  EXPECT_EQ(told.back().fraction, 1);
  EXPECT_TRUE(says("diagnosis.done"));
}

TEST_F(FullDiskDiagnosisTest, SaysToWhoCancelsThatTheEndWaitsForRoom) {
  refusals.of_ends = disk_full();
  const auto id = begun();
  cell.until([&] { return refusals.ends >= 1; });
  cell.pass(1);
  const auto refused = cell.await(cell->diagnoses.cancel(cell.ada, id));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "DISK_FULL");
  EXPECT_THAT(refused.error().message, HasSubstr("nothing is left to cancel"));
  refusals.of_ends.reset();
  cell.pass(6);
  EXPECT_EQ(look(id).state, JobState::done) << "the first end stands";
  EXPECT_TRUE(cell.await(cell->diagnoses.cancel(cell.ada, id)));
}

// A result that no waiting makes storable: the record says so instead of "running".
TEST_F(FullDiskDiagnosisTest, HasFailedWhereItsResultCannotBeStoredAtAll) {
  refusals.of_ends = Error{ErrorCode::internal, "STORE_FAILED", "string or blob too big"};
  const auto id = begun();
  cell.until([&] { return refusals.ends >= 2; });
  refusals.of_ends.reset();
  cell.pass(6);
  EXPECT_EQ(look(id).state, JobState::failed);
  EXPECT_EQ(look(id).reason, "what it found could not be stored: string or blob too big");
  EXPECT_TRUE(says("diagnosis.failed"));
}

TEST_F(FullDiskDiagnosisTest, OneWhoseEndWaitsDoesNotHoldTheDaemonAndHasFailedAtItsNextStart) {
  refusals.of_ends = disk_full();
  const auto id = begun();
  cell.until([&] { return refusals.ends >= 1; });
  cell.pass(1);
  const auto end = cell.now();
  bool is_down = false;
  asio::co_spawn(cell->host.executor(), cell.cell().shut_down(),
                 [&is_down](std::exception_ptr) { is_down = true; });
  cell.until([&] { return is_down; });
  EXPECT_EQ(refusals.ends, 2) << "once more at the end";
  cell.forget();
  CellInMemory again(world, small_cell(folder / "cell.sqlite"), kSqlite,
                     end + std::chrono::hours(1));
  const auto view = again.await(again->diagnoses.get(id));
  ASSERT_TRUE(view);
  EXPECT_EQ(view->record.state, JobState::failed);
}

TEST_F(FullDiskDiagnosisTest, AnImprovementWaitsForTheEndOfItsDiagnosisAndGoesOn) {
  refusals.of_ends = disk_full();
  const auto id = improving();
  cell.until([&] { return refusals.ends >= 1; }, 400'000);
  const int before = refusals.looks;
  cell.pass(60);
  EXPECT_LT(refusals.looks - before, 5) << "it waits for the record to change";
  refusals.of_ends.reset();
  cell.until([&] { return look(id).state != JobState::running; }, 400'000);
  EXPECT_EQ(look(id).state, JobState::done) << look(id).reason;
  EXPECT_EQ(look(id).reason, "nothing beyond noise is left");
}

TEST_F(FullDiskDiagnosisTest, AnImprovementIsUnderWayUntilItsOwnEndIsOnRecord) {
  const auto id = improving();
  cell.until([&] { return says("diagnosis.started"); }, 400'000);
  cell.until([&] { return refusals.ends >= 1; }, 400'000);  // the diagnosis' own, taken
  refusals.of_ends = disk_full();
  const auto cancelled = cell.await(cell->improvements.cancel(cell.ada, id));
  cell.pass(20);
  EXPECT_EQ(look(id).state, JobState::running);
  EXPECT_THAT(cell.events_named("improvement.trouble").at(0), HasSubstr("the disk is full"));
  const auto again = cell.await(cell->improvements.cancel(cell.ada, id));
  ASSERT_FALSE(again);
  EXPECT_THAT(again.error().message, HasSubstr("nothing is left to cancel"));
  refusals.of_ends.reset();
  cell.pass(6);
  EXPECT_NE(look(id).state, JobState::running);
}

}  // namespace
}  // namespace driftwise::tests
