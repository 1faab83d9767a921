// From a campaign to a model that serves and compensates.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "server/application/motion/datum_opening.h"
#include "server/compensation/correction_parts.h"
#include "server/compensation/target.h"
#include "server/core/units.h"
#include "server/formats/model/model_json.h"
#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

class ServingTest : public testing::Test {
 protected:
  Folder folder;
  SmallWorld world;
  CellInMemory cell{world, small_cell(folder / "cell.sqlite"), kSqlite};

  ModelRecord fit_after_campaign() {
    world.warming_k_per_h = 4;
    const auto run = cell.begin_run(lines_of(12, {-4, -2, 1, 3, 4}, true));
    cell.finish_run();
    application::FitRequest fit;
    fit.runs = {run.id};
    fit.formula = "q1 ~ x + t01";
    const auto model = cell.await(cell->models.fit(cell.ada, fit));
    if (!model) throw std::runtime_error(model.error().message);
    return *model;
  }
  double target_mm(double x_mm) {
    const auto snapshot = cell->targets.snapshots().read();
    compensation::TargetRequest request;
    request.set(compensation::Variable::x, x_mm);
    return compensation::compute_target(*snapshot, request).q_mm[0];
  }
};

TEST_F(ServingTest, NothingServesBeforeAPromotion) {
  cell.pass(20);
  EXPECT_FALSE(cell.status().serving);
  EXPECT_EQ(cell.await(cell->promotions.roll_back(cell.ada)).error().reason,
            "NOTHING_TO_ROLL_BACK");
  auto request = application::CreateRun{};
  request.trajectory_text = "x_mm\n1\n";
  request.compensate = true;
  EXPECT_EQ(cell.try_run(request).error().reason, "NO_MODEL");
}

TEST_F(ServingTest, ThePromotedModelFollowsTheTemperature) {
  const auto model = fit_after_campaign();
  ASSERT_TRUE(cell.await(cell->promotions.promote(cell.ada, model.id, true)));
  EXPECT_EQ(cell.status().serving, model.id);
  const double before_mm = target_mm(1.0);
  cell.pass(600);  // two thirds of a kelvin: the world grows by 150 nm/K
  const double moved_nm = (target_mm(1.0) - before_mm) * 1e6;
  EXPECT_NEAR(moved_nm, -150 * 4 / 6.0, 5);
}

TEST_F(ServingTest, ThePastOfATargetIsMadeFromTheRecordedTemperatures) {
  application::PastTargetsQuery query;
  query.pose.set(compensation::Variable::x, 1.0);
  EXPECT_EQ(cell.await(cell->targets.past(query)).error().reason, "NO_MODEL");
  const auto model = fit_after_campaign();
  cell.pass(1800);  // before it serves: what it would have said is known all the same
  ASSERT_TRUE(cell.await(cell->promotions.promote(cell.ada, model.id, true)));
  query.past = std::chrono::minutes(20);
  query.count = 40;
  const auto past = cell.await(cell->targets.past(query));
  ASSERT_TRUE(past) << past.error().message;
  ASSERT_EQ(past->tracks.size(), 1u);
  EXPECT_EQ(past->tracks[0].channel.name(), "q1_mm");
  const auto& nm = past->tracks[0].correction_nm;
  ASSERT_EQ(nm.size(), past->at.size());
  ASSERT_GE(nm.size(), 25u);
  // The world grows by 150 nm/K and warms by 4 K/h, a bucket is about half a minute.
  const double hours = seconds_from(past->at.back() - past->at.front()) / 3600;
  EXPECT_GT(hours, 0.25);
  EXPECT_NEAR((nm.back() - nm.front()) / hours, -150 * 4, 40);
  // It ends where the target of this moment stands.
  const auto snapshot = cell->targets.snapshots().read();
  const auto now = compensation::correction_parts(*snapshot, query.pose, 0);
  ASSERT_TRUE(now);
  EXPECT_NEAR(nm.back(), now->sum_nm(), 12);
  query.pose = {};
  EXPECT_EQ(cell.await(cell->targets.past(query)).error().reason, "MISSING_COORDINATE");
}

TEST_F(ServingTest, AModelThatIsFollowedLeavesTheTroubleOfTheServedOne) {
  const auto good = fit_after_campaign();
  application::FitRequest fit;  // of another cell: no datum of this one holds t99
  fit.formula = "q1 ~ x + t99";
  fit.csv = "q1_mm,x_mm,t99_degC\n";
  for (int i = 0; i < 40; ++i)
    fit.csv += fmt::format("{},{},{}\n", 1.0 * i + 1e-4 * (i % 7) + 1e-6 * (i % 3), i, 20 + i % 7);
  const auto foreign = cell.await(cell->models.fit(cell.ada, fit));
  ASSERT_TRUE(foreign) << foreign.error().message;
  ASSERT_TRUE(cell.await(cell->promotions.promote(cell.ada, foreign->id, true)));
  const auto said = [&] { return cell.status().attention; };
  ASSERT_THAT(said(), testing::Contains(testing::HasSubstr("does not anchor")));
  application::CreateRun compensated;
  compensated.trajectory_text = "x_mm\n1\n2\n";
  compensated.compensate = true;
  compensated.compensate_with = good.id;
  ASSERT_TRUE(cell.try_run(compensated));
  cell.finish_run();
  EXPECT_THAT(said(), testing::Contains(testing::HasSubstr("does not anchor")));
}

TEST_F(ServingTest, TheResidualsOfAFitAreThoseOfItsAccuracy) {
  const auto record = fit_after_campaign();
  const auto residuals = cell.await(cell->models.residuals(record.id, {}, ""));
  ASSERT_TRUE(residuals) << residuals.error().message;
  EXPECT_TRUE(residuals->same_rows);
  ASSERT_EQ(residuals->outputs.size(), 1u);
  double squares = 0;
  int calibration = 0;
  for (std::size_t row = 0; row < residuals->data.rows; ++row) {
    if (residuals->data.set_of(row) != PointSet::calibration) continue;
    squares += residuals->outputs[0].values[row] * residuals->outputs[0].values[row];
    ++calibration;
  }
  const auto model = *formats::read_model_json(record.json);
  EXPECT_NEAR(std::sqrt(squares / model.outputs[0].dof), model.outputs[0].accuracy.rmse * 1e6,
              1e-6);
  EXPECT_EQ(cell.await(cell->models.residuals(record.id, {}, "x_mm\n1\n")).error().reason,
            "UNKNOWN_CHANNEL");
}

TEST_F(ServingTest, AModelOfBeforeInstrumentsWereStatedKnowsItsRowsAgain) {
  application::FitRequest fit;
  fit.formula = "q1 ~ x";
  fit.csv = "q1_mm,x_mm\n";
  for (int i = 0; i < 40; ++i) fit.csv += fmt::format("{},{}\n", 1.0 * i + 1e-4 * (i % 7), i);
  const auto model = cell.await(cell->models.fit(cell.ada, fit));
  ASSERT_TRUE(model) << model.error().message;
  const auto rows_of = [&](const std::string& csv) {
    auto residuals = cell.await(cell->models.residuals(model->id, {}, csv));
    if (!residuals) throw std::runtime_error(residuals.error().message);
    return std::move(*residuals);
  };
  const std::string line = "# measured_by: x=laser-x\n";
  const auto same = rows_of(line + fit.csv);
  EXPECT_TRUE(same.same_rows);
  EXPECT_EQ(same.outputs[0].held_out.size(), 40u);
  EXPECT_FALSE(rows_of(line + fit.csv + "40,40\n").same_rows) << "a row more";
  EXPECT_FALSE(rows_of("# cell: another\n" + fit.csv).same_rows) << "another line changed";

  fit.csv = line + fit.csv;
  const auto stated = cell.await(cell->models.fit(cell.ada, fit));
  ASSERT_TRUE(stated) << stated.error().message;
  const auto unsaid =
      cell.await(cell->models.residuals(stated->id, {}, fit.csv.substr(line.size())));
  ASSERT_TRUE(unsaid);
  EXPECT_FALSE(unsaid->same_rows) << "who measured is part of what it was fitted to";
}

TEST_F(ServingTest, AFormulaIsJudgedOnTheRowsOfARun) {
  fit_after_campaign();
  application::FitRequest fit;
  fit.runs = {RunId{1}};
  fit.formula = "q1 ~ x + t0l";
  const auto check = cell.await(cell->models.check_formula(fit));
  ASSERT_TRUE(check) << check.error().message;
  EXPECT_NE(check->problem.find("t0l"), std::string::npos);
  fit.runs = {RunId{99}};
  EXPECT_FALSE(cell.await(cell->models.check_formula(fit))) << "no such run is an error of its own";
}

TEST_F(ServingTest, ACompensatedRunArrivesWhereItWasAsked) {
  const auto model = fit_after_campaign();
  ASSERT_TRUE(cell.await(cell->promotions.promote(cell.ada, model.id, true)));
  cell.pass(1800);  // 150 nm of drift since the campaign's end, more since its zero
  auto request = application::CreateRun{};
  request.trajectory_text =
      "x_mm,set,line\n1,validation,1\n-2.5,validation,1\n3.7,validation,1\n0.3,validation,1\n";
  request.compensate = true;
  const auto run = cell.try_run(request);
  ASSERT_TRUE(run) << run.error().message;
  const auto ended = cell.finish_run();
  ASSERT_EQ(ended.state, RunState::done) << ended.reason;
  const auto all_points = *cell.await(cell.points(run->id, 0, 100));
  for (const auto& point : all_points) {
    double x = kMissing, wanted = kMissing;
    for (const auto& v : point.values) {
      if (v.channel == "x_mm") x = v.value;
      if (v.channel == "x_target_mm") wanted = v.value;
    }
    EXPECT_NEAR((x - wanted) * 1e6, 0, 60)
        << point.row;  // the holding of this axis: sd 8 nm, and the datum's zero
    EXPECT_NE(point.commanded_mm[0], wanted);
  }
}

TEST_F(ServingTest, AVerificationSaysWhatCompensationAchieved) {
  const auto model = fit_after_campaign();
  ASSERT_TRUE(cell.await(cell->promotions.promote(cell.ada, model.id, true)));
  world.bend_nm_per_mm2 = 0;
  auto request = application::CreateRun{};
  request.trajectory_text =
      "x_mm,set,line,zero\n0,validation,1,1\n1,validation,1,0\n-2.5,validation,1,0\n"
      "3.7,validation,1,0\n4.6,validation,1,0\n";
  request.compensate = true;
  const auto with = cell.try_run(request);
  ASSERT_TRUE(with) << with.error().message;
  ASSERT_EQ(cell.finish_run().state, RunState::done);
  request.compensate = false;
  const auto without = cell.try_run(request);
  ASSERT_TRUE(without) << without.error().message;
  ASSERT_EQ(cell.finish_run().state, RunState::done);

  const auto found = cell.await(cell->checks.verify_runs({with->id, without->id}, std::nullopt));
  ASSERT_TRUE(found) << found.error().message;
  ASSERT_EQ(found->runs.size(), 2u);
  const auto& run = found->runs[0];
  EXPECT_TRUE(run.compensated);
  EXPECT_EQ(run.with, model.id);
  EXPECT_FALSE(found->runs[1].compensated);
  EXPECT_EQ(run.rows, 4);
  EXPECT_EQ(run.rows_zero, 1);
  ASSERT_EQ(run.coordinates.size(), 1u);
  const auto& x = run.coordinates[0];
  EXPECT_EQ(x.unit, "nm");
  EXPECT_GE(run.rows_outside, 1);  // 4.6 mm: the campaign went to 4
  EXPECT_EQ(x.inside.rows + x.outside.rows, 4);
  ASSERT_TRUE(x.by_model.has_value());
  std::vector<double> errors;
  const auto points = cell.await(cell.points(with->id, 0, 100));
  ASSERT_TRUE(points);
  for (const auto& point : *points) {
    double measured = kMissing, wanted = kMissing;
    for (const auto& v : point.values) {
      if (v.channel == "x_mm") measured = v.value;
      if (v.channel == "x_target_mm") wanted = v.value;
    }
    if (!point.zero) errors.push_back((wanted - measured) * 1e6);
  }
  const auto by_hand = error_figures(errors);
  EXPECT_NEAR(x.all.mean, by_hand.mean, 1e-6);
  EXPECT_NEAR(x.all.u90, by_hand.u90, 1e-6);
  EXPECT_NEAR(x.all.a90, by_hand.a90, 1e-6);
  ASSERT_EQ(found->changes.size(), 1u);
  EXPECT_EQ(found->changes[0].positions, 4);
  ASSERT_EQ(found->heading.size(), 1u);
  EXPECT_EQ(found->heading[0].figures, x.all);
  ASSERT_TRUE(found->heading[0].before.has_value());
  EXPECT_EQ(*found->heading[0].before, found->runs[1].coordinates[0].all);
  // What the file of the run says of it.
  EXPECT_NE(cell.await(cell->datasets.export_csv({with->id, without->id}, false))
                ->find("# compensation: run 2 with model 1, run 3 none\n"),
            std::string::npos);
  EXPECT_EQ(cell.await(cell->checks.verify_runs({RunId{99}}, std::nullopt)).error().code,
            ErrorCode::not_found);
}

// The run returns to zero by itself after each line: its rows 3 to 5 are not the places 3 to 5 of
// its dataset.
TEST_F(ServingTest, AVerificationNamesTheRowOfThePlan) {
  const auto model = fit_after_campaign();
  ASSERT_TRUE(cell.await(cell->promotions.promote(cell.ada, model.id, true)));
  auto request = application::CreateRun{};
  request.trajectory_text =
      "x_mm,set,line\n1,validation,1\n-2.5,validation,1\n3.7,validation,2\n-1,validation,2\n"
      "2,validation,3\n";
  const auto run = cell.try_run(request);
  ASSERT_TRUE(run) << run.error().message;
  ASSERT_EQ(cell.finish_run().state, RunState::done);
  const auto found = cell.await(cell->checks.verify_runs({run->id}, std::nullopt));
  ASSERT_TRUE(found) << found.error().message;
  const auto& x = found->runs.at(0).coordinates.at(0);
  const auto points = cell.await(cell.points(run->id, 0, 100, true));
  ASSERT_TRUE(points);
  ASSERT_GT(points->size(), 8u) << "five points and the passages";
  const auto named = std::ranges::find_if(*points, [&](const PointRecord& point) {
    return point.row == static_cast<std::int64_t>(x.largest_row);
  });
  ASSERT_NE(named, points->end());
  ASSERT_FALSE(named->passage);
  const double error_mm = *application::find_value(named->values, "x_target_mm") -
                          *application::find_value(named->values, "x_mm");
  EXPECT_NEAR(x.largest, error_mm * 1e6, 1e-6);
}

TEST_F(ServingTest, ATargetAfterHomingByHandCountsFromTheNewDatum) {
  const auto model = fit_after_campaign();
  ASSERT_TRUE(cell.await(cell->promotions.promote(cell.ada, model.id, true)));
  const auto run_datum = cell.await(cell.datums(RunId{1}))->back();
  cell.pass(1800);         // 300 nm of growth since, which is what the instruments would show ...
  world.homing_nm = 2000;  // ... and scales that begin elsewhere
  ASSERT_TRUE(cell.await(cell->manual.home(cell.ada, cell.lease())));
  EXPECT_EQ(world.zeroings, 2);
  const auto opened = cell.events_named("datum.opened");
  EXPECT_EQ(opened.back(), "datum 2: homed by ada");
  EXPECT_EQ(cell.events_named("zero.compared").size() + cell.events_named("zero.surprising").size(),
            1u);
  EXPECT_TRUE(cell.status().attention.empty());
  // Zeroed here and now: the pose 0 is where the robot stands, whatever the model's own datum was.
  EXPECT_NEAR(target_mm(0), world.to_mm + world.reference_mm, 60e-6);  // holding: sd 8 nm
}

TEST_F(ServingTest, TheDatumOfAHomingByHandIsThereAfterARestart) {
  ASSERT_TRUE(cell.await(cell->manual.home(cell.ada, cell.lease())));
  cell.shut_down();
  auto store = kSqlite(folder / "cell.sqlite", true);
  ASSERT_TRUE(store);
  const auto datum = (*store)->points().newest_datum();
  ASSERT_TRUE(datum && *datum);
  EXPECT_FALSE((*datum)->run);
  EXPECT_EQ((*datum)->reason, "homed by ada");
}

TEST_F(ServingTest, HomingWaitsForTheStabiliserAndSaysSo) {
  world.support_degc = 22;
  std::optional<Result<void>> done;
  cell.begin(cell->manual.home(cell.ada, cell.lease()), done);
  cell.until([&] { return !cell.status().attention.empty(); });
  cell.until([&] {
    const auto attention = cell.status().attention;
    return std::ranges::any_of(attention, [](const std::string& sentence) {
      return sentence.starts_with("homing waits: the stabiliser support is at 22.");
    });
  });
  EXPECT_FALSE(done);
  world.support_degc = 23;
  cell.until([&] { return done.has_value(); });
  EXPECT_TRUE(*done);
  EXPECT_TRUE(cell.status().attention.empty());
}

TEST_F(ServingTest, HomingMovesNothingWhileADeviceOfTheDatumDoesNotAnswer) {
  for (bool SmallWorld::*const is_away : {&SmallWorld::scanner_away, &SmallWorld::laser_away}) {
    world.*is_away = true;
    const auto homed = cell.await(cell->manual.home(cell.ada, cell.lease()));
    ASSERT_FALSE(homed);
    EXPECT_THAT(homed.error().message, testing::HasSubstr("nothing has moved"));
    EXPECT_EQ(world.homes + world.moves, 0);
    EXPECT_THAT(cell.status().attention,
                testing::Not(testing::Contains(testing::HasSubstr("no datum has been opened"))));
    world.*is_away = false;
    cell.pass(120);
  }
}

TEST_F(ServingTest, HomingThatEndsWithoutADatumIsSaid) {
  std::optional<Result<void>> done;
  cell.begin(cell->manual.home(cell.ada, cell.lease()), done);
  cell.until([&] { return world.homes == 1; });
  world.scanner_away = true;
  cell.until([&] { return done.has_value(); });
  const auto& homed = *done;
  ASSERT_FALSE(homed);
  EXPECT_THAT(
      homed.error().message,
      testing::StartsWith("the axes have moved to their reference, and no datum was opened"));
  const auto attention = cell.status().attention;
  EXPECT_TRUE(std::ranges::any_of(attention, [](const std::string& sentence) {
    return sentence.starts_with("the axes were homed and no datum has been opened since");
  }));
}

TEST_F(ServingTest, RollBackServesTheModelBefore) {
  const auto first = fit_after_campaign();
  application::FitRequest fit;
  fit.runs = {RunId{1}};
  fit.formula = "q1 ~ x + x^2";
  fit.select = "all";
  const auto second = cell.await(cell->models.fit(cell.ada, fit));
  ASSERT_TRUE(second) << second.error().message;
  ASSERT_TRUE(cell.await(cell->promotions.promote(cell.ada, first.id, true)));
  ASSERT_TRUE(cell.await(cell->promotions.promote(cell.ada, second->id, true)));
  const auto back = cell.await(cell->promotions.roll_back(cell.ada));
  ASSERT_TRUE(back && *back);
  EXPECT_EQ((*back)->id, first.id);
  EXPECT_EQ(cell.status().serving, first.id);
  const auto none = cell.await(cell->promotions.roll_back(cell.ada));
  ASSERT_TRUE(none);
  EXPECT_FALSE(*none);
  EXPECT_FALSE(cell.status().serving);
}

TEST_F(ServingTest, APromotionOfTheModelThatServesAlreadyWritesNothing) {
  const auto model = fit_after_campaign();
  ASSERT_TRUE(cell.await(cell->promotions.promote(cell.ada, model.id, true)));
  const auto before = *cell.await(cell->records.models().promotions());
  const auto again = cell.await(cell->promotions.promote(cell.ada, model.id, false));
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(again->id, model.id);
  EXPECT_EQ(cell.await(cell->records.models().promotions())->size(), before.size());
  const auto none = cell.await(cell->promotions.roll_back(cell.ada));
  ASSERT_TRUE(none);
  EXPECT_FALSE(*none) << "one promotion is taken back by one rollback";
}

// The rows are joined in the order of time, so that the constant belongs to the earliest zero.
TEST_F(ServingTest, AModelOfSeveralRunsIsTheSameInWhateverOrderTheyWereNamed) {
  cell.begin_run(lines_of(12, {-4, -2, 1, 3, 4}, true));
  cell.finish_run();
  cell.pass(1800);
  world.homing_nm = 3000;  // another zero
  ASSERT_TRUE(cell.await(cell->manual.home(cell.ada, cell.lease())));
  cell.begin_run(lines_of(12, {-4, -2, 1, 3, 4}, true));
  cell.finish_run();
  std::vector<double> q_mm;
  for (const auto& runs : {std::vector{RunId{1}, RunId{2}}, std::vector{RunId{2}, RunId{1}}}) {
    application::FitRequest fit;
    fit.runs = runs;
    fit.formula = "q1 ~ x + t01";
    const auto model = cell.await(cell->models.fit(cell.ada, fit));
    ASSERT_TRUE(model) << model.error().message;
    ASSERT_TRUE(cell.await(cell->promotions.promote(cell.ada, model->id, true)));
    q_mm.push_back(target_mm(0.0));
  }
  EXPECT_NEAR(q_mm[0], q_mm[1], 1e-9);
}

TEST_F(ServingTest, OfAModelThatServesNoLongerNoZeroIsAskedFor) {
  cell.begin_run(lines_of(12, {-4, -2, 1, 3, 4}, true));
  cell.finish_run();
  application::FitRequest foreign;
  foreign.formula = "q1 ~ x + t99";  // which this cell does not read
  foreign.csv = "q1_mm,x_mm,t99_degC\n";
  for (int i = 0; i < 40; ++i)
    foreign.csv += fmt::format("{},{},{}\n", i + 1e-4 * (i % 7) + 1e-6 * (i % 3), i, 20 + i % 7);
  const auto other = cell.await(cell->models.fit(cell.ada, foreign));
  ASSERT_TRUE(other) << other.error().message;
  ASSERT_TRUE(cell.await(cell->promotions.promote(cell.ada, other->id, true)));
  application::FitRequest own;
  own.runs = {RunId{1}};
  own.formula = "q1 ~ x + t01";
  const auto model = *cell.await(cell->models.fit(cell.ada, own));
  ASSERT_TRUE(cell.await(cell->promotions.promote(cell.ada, model.id, true)));
  const auto before = cell.events_named("serving.unanchored").size();
  ASSERT_TRUE(cell.await(cell->manual.home(cell.ada, cell.lease())));
  EXPECT_EQ(cell.events_named("serving.unanchored").size(), before);
}

TEST_F(ServingTest, ARollbackTakesBackTheModelThatItWasAskedAbout) {
  const auto first = fit_after_campaign();
  ASSERT_TRUE(cell.await(cell->promotions.promote(cell.ada, first.id, true)));
  application::FitRequest fit;
  fit.runs = {RunId{1}};
  fit.formula = "q1 ~ x";
  const auto second = cell.await(cell->models.fit(cell.ada, fit));
  ASSERT_TRUE(second) << second.error().message;
  ASSERT_TRUE(cell.await(cell->promotions.promote(cell.ada, second->id, true)));
  const auto refused = cell.await(cell->promotions.roll_back(cell.ada, first.id));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "STALE");
  EXPECT_EQ(cell.status().serving, second->id);
  ASSERT_TRUE(cell.await(cell->promotions.roll_back(cell.ada, second->id)));
  EXPECT_EQ(cell.status().serving, first.id);
}

TEST_F(ServingTest, TheSameFitAgainIsTheSameModel) {
  const auto model = fit_after_campaign();
  application::FitRequest fit;
  fit.runs = {RunId{1}};
  fit.formula = "q1 ~ x + t01";
  fit.name = "second name";
  cell.pass(10);
  EXPECT_EQ(cell.await(cell->models.fit(cell.ada, fit))->id, model.id);
  const auto events = cell.events_named("model.fitted");
  ASSERT_EQ(events.size(), 2);
  const std::string again = "the same content again, stored as '" + model.name + "'";
  EXPECT_EQ(
      std::ranges::count_if(
          events, [&](const std::string& one) { return one.find(again) != std::string::npos; }),
      1);
}

}  // namespace
}  // namespace driftwise::tests
