// Diagnoses as jobs: progress, cancelling, restarts, and fits that do not wait for them.

#include <gmock/gmock.h>

#include <algorithm>

#include "tests/unit/application/diagnosis/diagnosed_cell.h"

namespace driftwise::tests {
namespace {

using application::DiagnosisProgress;
using testing::ElementsAre;
using testing::HasSubstr;

const std::string kPlan = lines_of(4, {-3, -1, 2, 4}, true);

Result<dx::Diagnosis> finds_a_bend(const Dataset& data, const dx::DiagnoseOptions& options) {
  if (!options.progress(0.5, "looking for a cause in q1"))
    return fail(ErrorCode::cancelled, "CANCELLED", "cancelled");
  auto d = diagnosis_with(
      options.baseline.formula,
      {finding_of("geometry_order", "x", effects::AppliesTo::robot, {"x^2"}, {1e-4})});
  d.rows_calibration = data.rows;
  return d;
}

TEST(DiagnosisDesk, StoresWhatWasFoundAndSaysSo) {
  DiagnosedCell d(finds_a_bend);
  const auto run = d.measured(kPlan);
  std::vector<std::string> steps;
  const auto watch = d.cell->diagnoses.watch(
      [&](const DiagnosisProgress& progress) { steps.push_back(progress.step); });
  const auto begun = d.begin_diagnosis(run, "q ~ x");
  EXPECT_EQ(begun.record.state, JobState::running);
  d.cell.until([&] { return d.look(begun.record.id).record.state != JobState::running; });
  const auto view = d.look(begun.record.id);
  EXPECT_EQ(view.record.state, JobState::done);
  EXPECT_THAT(view.record.runs, ElementsAre(run));
  ASSERT_TRUE(view.found);
  ASSERT_EQ(view.found->findings.size(), 1u);
  EXPECT_EQ(view.found->findings[0].cause, "geometry_order");
  EXPECT_EQ(view.found->rows_calibration, 20u);
  EXPECT_THAT(steps, ElementsAre("waiting for its turn", "looking for a cause in q1", "done"));
  EXPECT_THAT(d.cell.events_named("diagnosis.done").at(0), HasSubstr("geometry_order x"));
  EXPECT_EQ(d.cell.await(d.cell->diagnoses.list())->size(), 1u);
}

TEST(DiagnosisDesk, StandsInTheAuditWithWhatProvedWhoBeganIt) {
  DiagnosedCell d(finds_a_bend);
  application::DiagnosisRequest request;
  request.runs = {d.measured(kPlan)};
  request.baseline = "q ~ x";
  const application::Caller carl{"carl", "ipv4:10.0.0.2:1 (token k3f9)", "token k3f9"};
  const auto begun = d.cell.await(d.cell->diagnoses.create(carl, std::move(request)));
  ASSERT_TRUE(begun);
  d.cell.until([&] { return d.look(begun->record.id).record.state != JobState::running; });
  const auto acts =
      d.cell.await(d.cell.read([](Store& store) { return store.audit().acts(0, 100); })).value();
  const auto act = std::ranges::find(acts, "diagnosis.started", &AuditRecord::what);
  ASSERT_NE(act, acts.end());
  EXPECT_EQ(act->by.name, "carl");
  EXPECT_EQ(act->by.proof, "token k3f9");
  EXPECT_EQ(act->by.from, carl.peer);
}

TEST(DiagnosisDesk, WhoWatchesTheRecordIsCalledForItsEndAndFindsItThere) {
  DiagnosedCell d(finds_a_bend);
  const auto run = d.measured(kPlan);
  const auto head =
      d.cell.await(d.cell.read([](Store& store) { return store.records().newest(); })).value();
  int called = 0;
  const auto watch = d.cell->feeds.watch_records([&] { ++called; });
  const auto id = d.begin_diagnosis(run, "q ~ x").record.id;
  d.cell.until([&] { return d.look(id).record.state != JobState::running; });
  EXPECT_GT(called, 0);
  const auto now =
      d.cell.await(d.cell.read([](Store& store) { return store.records().newest(); })).value();
  const auto page =
      d.cell
          .await(d.cell.read([&](Store& store) { return store.records().records(head, now, 100); }))
          .value();
  ASSERT_EQ(page.diagnoses.size(), 1u);
  EXPECT_EQ(page.diagnoses[0].id, id);
  EXPECT_EQ(page.diagnoses[0].state, JobState::done);
}

TEST(DiagnosisDesk, ACancelledOneIsOverBeforeItsThreadHasNoticed) {
  DiagnosedCell d(finds_a_bend, true);  // its thread does not get a turn
  const auto run = d.measured(kPlan);
  const auto id = d.begin_diagnosis(run, "q ~ x").record.id;
  const auto before = d.cell.now();
  const auto cancelled = d.cell.await(d.cell->diagnoses.cancel(d.cell.ada, id));
  ASSERT_TRUE(cancelled);
  EXPECT_EQ(cancelled->record.state, JobState::cancelled);
  EXPECT_EQ(cancelled->record.reason, "cancelled by ada");
  EXPECT_LT(seconds_from(d.cell.now() - before), 0.1);
  d.let_diagnoses_run();
  d.cell.pass(1);
  EXPECT_EQ(d.look(id).record.state, JobState::cancelled);  // the first end stands
  EXPECT_FALSE(d.look(id).found);
}

TEST(DiagnosisDesk, AFitDoesNotWaitForADiagnosis) {
  DiagnosedCell d(finds_a_bend, true);
  const auto run = d.measured(kPlan);
  const auto id = d.begin_diagnosis(run, "q ~ x").record.id;
  application::FitRequest fit;
  fit.runs = {run};
  fit.formula = "q ~ x";
  ASSERT_TRUE(d.cell.await(d.cell->models.fit(d.cell.ada, fit)));
  EXPECT_EQ(d.look(id).record.state, JobState::running);
}

TEST(DiagnosisDesk, RefusesANinthAtOnce) {
  DiagnosedCell d(finds_a_bend, true);
  const auto run = d.measured(kPlan);
  for (int i = 0; i < 8; ++i) d.begin_diagnosis(run, "q ~ x");
  application::DiagnosisRequest ninth;
  ninth.runs = {run};
  ninth.baseline = "q ~ x";
  const auto refused = d.cell.await(d.cell->diagnoses.create(d.cell.ada, ninth));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "TOO_MANY_DIAGNOSES");
}

TEST(DiagnosisDesk, FailsWithTheReasonOfTheSearch) {
  DiagnosedCell d([](const Dataset&, const dx::DiagnoseOptions&) -> Result<dx::Diagnosis> {
    return fail(ErrorCode::invalid_argument, "TOO_FEW_ROWS", "found 3 rows, expected 20");
  });
  const auto run = d.measured(kPlan);
  const auto view = d.diagnosed(run, "q ~ x");
  EXPECT_EQ(view.record.state, JobState::failed);
  EXPECT_EQ(view.record.reason, "found 3 rows, expected 20");
}

TEST(DiagnosisDesk, RefusesAFormulaThatTheDataLackAChannelFor) {
  DiagnosedCell d(finds_a_bend);
  const auto run = d.measured(kPlan);
  application::DiagnosisRequest request;
  request.runs = {run};
  request.baseline = "q ~ x + t77";
  EXPECT_EQ(d.cell.await(d.cell->diagnoses.create(d.cell.ada, request)).error().reason,
            "UNKNOWN_CHANNEL");
  request.baseline.clear();  // and nothing serves
  EXPECT_EQ(d.cell.await(d.cell->diagnoses.create(d.cell.ada, request)).error().reason, "NO_MODEL");
}

TEST(DiagnosisDesk, OneUnderWayWhenTheDaemonEndsHasFailedAtTheNextStart) {
  Folder folder;
  SmallWorld world;
  asio::io_context elsewhere;
  const auto description = small_cell(folder / "cell.sqlite");
  DiagnosisId id;
  {
    CellInMemory cell(world, description, kSqlite,
                      {.begin = kWorldBegin,
                       .diagnose = finds_a_bend,
                       .diagnosis_thread = elsewhere.get_executor()});
    cell.begin_run(kPlan);
    const auto run = cell.finish_run();
    application::DiagnosisRequest request;
    request.runs = {run.id};
    request.baseline = "q ~ x";
    id = cell.await(cell->diagnoses.create(cell.ada, request))->record.id;
    asio::post(elsewhere, [] {});
    bool down = false;
    // Ends in good order: the search is told to stop and gets its turn to notice.
    asio::co_spawn(cell->host.executor(), cell.cell().shut_down(),
                   [&down](std::exception_ptr) { down = true; });
    cell.until([&] {
      elsewhere.restart();
      elsewhere.poll();
      return down;
    });
    cell.forget();
  }
  CellInMemory again(world, description, kSqlite, kWorldBegin + std::chrono::hours(24));
  const auto view = again.await(again->diagnoses.get(id));
  ASSERT_TRUE(view);
  EXPECT_EQ(view->record.state, JobState::failed);
  EXPECT_THAT(view->record.reason, HasSubstr("the daemon"));
}

}  // namespace
}  // namespace driftwise::tests
