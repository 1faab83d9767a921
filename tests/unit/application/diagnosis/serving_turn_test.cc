// Two people who change what serves, or what corrects the data, at the same time.

#include <gtest/gtest.h>

#include <cmath>

#include "server/formats/csv/dataset_csv.h"
#include "tests/support/small_cell_file.h"
#include "tests/unit/application/diagnosis/diagnosed_cell.h"

namespace driftwise::tests {
namespace {

using effects::AppliesTo;

const application::Caller kBob{"bob", "ipv4:127.0.0.1:5021", {}};
constexpr int kMostSteps = 12;  // of the executor, between the beginnings of two changes

// A campaign with two models and a diagnosis; the first model serves.
struct TwoModels {
  std::vector<dx::Finding> findings{
      finding_of("thermal_offset", "t01", AppliesTo::robot, {"t01"}, {1e-6})};
  DiagnosedCell d{
      [this](const Dataset&, const dx::DiagnoseOptions& options) -> Result<dx::Diagnosis> {
        return diagnosis_with(options.baseline.formula, findings);
      }};
  RunId run = d.measured(lines_of(6, {-4, -2, 1, 3, 4}, true));
  ModelId first = fitted("q1 ~ x"), other = fitted("q1 ~ x + t02");
  DiagnosisId diagnosis = d.diagnosed(run, "q ~ x").record.id;

  TwoModels() {
    EXPECT_TRUE(d.cell.await(d.cell->promotions.promote(d.cell.ada, first, true)));
    d.cell.pass(5);
  }
  ModelId fitted(const std::string& formula) {
    application::FitRequest fit;
    fit.runs = {run};
    fit.formula = formula;
    fit.select = "all";
    return d.cell.await(d.cell->models.fit(d.cell.ada, fit))->id;
  }
  void turn_executor(int steps) {
    for (int i = 0; i < steps; ++i)
      if (d.cell.io().poll_one() == 0) d.cell.io().restart();
  }
  template <class One, class Other>
  void both(Awaitable<One> one, int steps, Awaitable<Other> two) {
    std::optional<One> first_answer;
    std::optional<Other> second_answer;
    d.cell.begin(std::move(one), first_answer);
    turn_executor(steps);
    d.cell.begin(std::move(two), second_answer);
    d.cell.until([&] { return first_answer && second_answer; });
    d.cell.pass(1);
  }
  std::vector<PromotionRecord> history() { return *d.cell.await(d.cell.promotions()); }
  void expect_that_the_last_promotion_serves(int steps) {
    EXPECT_EQ(d.cell.status().serving, history().back().model)
        << "the second change began " << steps << " steps after the first";
  }
};

TEST(ServingTurn, WhatServesIsWhatIsOnRecordAfterAnAcceptanceBesideAPromotion) {
  for (int steps = 0; steps <= kMostSteps; ++steps) {
    TwoModels s;
    auto& cell = s.d.cell;
    s.both(cell->extensions.accept(cell.ada, {s.diagnosis, {1}, true, true}), steps,
           cell->promotions.promote(kBob, s.other, true));
    s.expect_that_the_last_promotion_serves(steps);
  }
}

TEST(ServingTurn, AnUndoBesideAPromotionTakesBackOnlyWhatServes) {
  for (int steps = 0; steps <= kMostSteps; ++steps) {
    TwoModels s;
    auto& cell = s.d.cell;
    ASSERT_TRUE(cell.await(cell->extensions.accept(cell.ada, {s.diagnosis, {1}, true, true})));
    s.both(cell->extensions.undo(cell.ada, s.diagnosis), steps,
           cell->promotions.promote(kBob, s.other, true));
    s.expect_that_the_last_promotion_serves(steps);
    EXPECT_EQ(cell.status().serving, s.other) << "bob's promotion was taken back, " << steps;
  }
}

TEST(ServingTurn, TwoRollbacksAtOnceTakeBackTwoPromotions) {
  for (int steps = 0; steps <= kMostSteps; ++steps) {
    TwoModels s;
    auto& cell = s.d.cell;
    ASSERT_TRUE(cell.await(cell->promotions.promote(cell.ada, s.other, true)));
    s.both(cell->promotions.roll_back(cell.ada), steps, cell->promotions.roll_back(kBob));
    EXPECT_FALSE(cell.status().serving) << steps;
    s.expect_that_the_last_promotion_serves(steps);
  }
}

TEST(ServingTurn, TwoDiagnosesOfOneErrorTakeItOffOnce) {
  std::vector<dx::Finding> findings{finding_of("cyclic_error", "x", AppliesTo::correction,
                                               {"sin(x, 93000 nm)", "cos(x, 93000 nm)"},
                                               {-1.0002 * kCycleNm * 1e-6, 0})};
  DiagnosedCell d([&](const Dataset&, const dx::DiagnoseOptions& options) -> Result<dx::Diagnosis> {
    return diagnosis_with(options.baseline.formula, findings);
  });
  const auto run =
      d.cell.await(d.cell->datasets.import_csv(d.cell.ada, "a", imported_csv(), ""))->id;
  const auto one = d.diagnosed(run, "q ~ x").record.id, two = d.diagnosed(run, "q ~ x").record.id;
  d.cell.pass(60);
  std::optional<Result<ExtensionRecord>> first, second;
  d.cell.begin(d.cell->extensions.accept(d.cell.ada, {one, {}, false}), first);
  d.cell.begin(d.cell->extensions.accept(kBob, {two, {}, false}), second);
  d.cell.until([&] { return first && second; });
  ASSERT_TRUE(*first) << first->error().message;
  ASSERT_FALSE(*second);
  EXPECT_EQ(second->error().reason, "STALE");
}

// What a promotion asks does not depend on whether it comes with the acceptance or after it.
TEST(ServingTurn, AnAcceptanceThatPromotesAsksWhatThePromotionAsks) {
  Folder folder;
  SmallWorld world;
  CellTime begin = kWorldBegin;
  const std::string text = small_cell_text(folder / "cell.sqlite");
  std::vector<dx::Finding> findings{
      finding_of("thermal_offset", "t01", AppliesTo::robot, {"t01"}, {1e-6})};
  std::unique_ptr<CellInMemory> cell;
  const auto start = [&](const std::string& file) {
    cell.reset();
    begin = begin + std::chrono::hours(1);
    cell = std::make_unique<CellInMemory>(
        world, cell_of(file), kSqlite,
        CellInMemory::Further{.begin = begin,
                              .diagnose = [&](const Dataset&, const dx::DiagnoseOptions& options)
                                  -> Result<dx::Diagnosis> {
                                return diagnosis_with(options.baseline.formula, findings);
                              }});
    cell->pass(30);
  };
  start(text);
  application::DiagnosisRequest request;
  request.runs = {cell->begin_run(lines_of(12, {-4, -2, 1, 3, 4}, true)).id};
  request.baseline = "q ~ x";
  cell->finish_run();
  const auto id = cell->await((*cell)->diagnoses.create(cell->ada, request))->record.id;
  cell->until(
      [&] { return cell->await((*cell)->diagnoses.get(id))->record.state != JobState::running; });
  start(replaced(replaced(replaced(text, "input = 101", "input = 0"), "input = 102", "input = 101"),
                 "input = 0", "input = 102"));  // two plugs changed places
  ASSERT_TRUE(cell->await((*cell)->configurations.accept(
      cell->ada, (*cell)->overview.description().hash, "the plugs were changed")));
  const auto preview = cell->await((*cell)->extensions.preview({id, {1}, true}));
  ASSERT_TRUE(preview) << preview.error().message;
  const auto accepted = cell->await((*cell)->extensions.accept(cell->ada, {id, {1}, false}));
  ASSERT_TRUE(accepted) << accepted.error().message;
  const auto ground = cell->await((*cell)->provenance.ground_of_model(*accepted->model));
  ASSERT_TRUE(ground) << ground.error().message;
  EXPECT_EQ(preview->promotion_questions, ground->promotion_questions);
  EXPECT_GE(ground->promotion_questions.size(), 2U);
}

}  // namespace
}  // namespace driftwise::tests
