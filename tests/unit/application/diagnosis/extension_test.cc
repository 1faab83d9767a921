// What is made of findings, by where they apply; and taken back.

#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "server/application/diagnoses/extension_plan.h"
#include "server/application/diagnoses/taken_side.h"
#include "server/application/provenance/provenance.h"
#include "server/compensation/target.h"
#include "server/formats/csv/dataset_csv.h"
#include "server/formats/diagnosis/diagnosis_json.h"
#include "server/formats/model/model_json.h"
#include "storage/sqlite/database.h"
#include "tests/unit/application/diagnosis/diagnosed_cell.h"

namespace driftwise::tests {
namespace {

using effects::AppliesTo;
using testing::ElementsAre;
using testing::HasSubstr;

class ExtensionTest : public testing::Test {
 protected:
  ExtensionTest()
      : d([this](const Dataset&, const dx::DiagnoseOptions& options) -> Result<dx::Diagnosis> {
          names = {options.name_of_row(0), options.name_of_row(7), options.name_of_row(12)};
          return diagnosis_with(options.baseline.formula, findings);
        }) {
    run = imported("campaign");
    make_own(run);
  }
  RunId imported(const std::string& name) {
    const auto of_file =
        d.cell.await(d.cell->datasets.import_csv(d.cell.ada, name, imported_csv(), ""));
    if (!of_file) throw std::runtime_error(of_file.error().message);
    return of_file->id;
  }
  // As if this cell had measured its rows: a join of its own runs.
  void make_own(RunId id) {
    storage::Database(d.folder / "cell.sqlite", SQLITE_OPEN_READWRITE, "")
        .execute("UPDATE run SET rules_json = '{\"joined\":{}}' WHERE run_id = " +
                 std::to_string(id.value));
  }
  std::string exported(RunId id) { return *d.cell.await(d.cell->datasets.export_csv({id}, false)); }
  Result<ExtensionRecord> accept(DiagnosisId id, std::vector<int> numbers = {},
                                 bool promote = false) {
    return d.cell.await(d.cell->extensions.accept(d.cell.ada, {id, std::move(numbers), promote}));
  }
  calibration::Model model(ModelId id) {
    return *formats::read_model_json(d.cell.await(d.cell->models.get(id))->json);
  }
  Dataset data() {
    return *formats::read_dataset_csv(*d.cell.await(d.cell->datasets.export_csv({run}, false)),
                                      "e");
  }
  double rmse_nm(const calibration::Model& m) { return m.outputs[0].accuracy.rmse * 1e6; }
  double target_mm(double x_mm) {
    compensation::TargetRequest request;
    request.set(compensation::Variable::x, x_mm);
    return compensation::compute_target(*d.cell->targets.snapshots().read(), request).q_mm[0];
  }

  // What the scripted search answers with, and what it would name the rows 0, 7 and 12.
  std::vector<dx::Finding> findings;
  std::vector<std::string> names;
  // In q1 the cycle shows with the other sign, times the axis' 1.0002.
  dx::Finding cycle() const {
    return finding_of("cyclic_error", "x", AppliesTo::correction,
                      {"sin(x, 93000 nm)", "cos(x, 93000 nm)"}, {-1.0002 * kCycleNm * 1e-6, 0});
  }
  dx::Finding outlier() const {
    auto finding = finding_of("outliers", "", AppliesTo::dataset, {}, {});
    finding.rows = {7};
    return finding;
  }
  dx::Finding bend() const {
    return finding_of("thermal_offset", "t01", AppliesTo::robot, {"t01"}, {1e-6});
  }

  DiagnosedCell d;
  RunId run;
};

TEST_F(ExtensionTest, AnInstrumentsErrorIsCorrectedInTheDataAndStaysOutOfTheModel) {
  findings = {cycle(), outlier()};
  const auto before = data();
  const auto id = d.diagnosed(run, "q ~ x").record.id;
  const auto made = accept(id);
  ASSERT_TRUE(made) << made.error().message;
  ASSERT_TRUE(made->correction && made->model);
  ASSERT_EQ(made->excluded.size(), 1u);
  EXPECT_THAT(made->excluded[0].rows, ElementsAre(7));
  const auto m = model(*made->model);
  EXPECT_EQ(m.formula, "q ~ x");  // no term of the instrument's
  EXPECT_NEAR(m.outputs[0].coefficients[1], 1.0002, 1e-6);
  EXPECT_LT(rmse_nm(m), 3.5);  // the noise is 2 nm; the cycle alone would be 28
  EXPECT_EQ(m.lineage.rows_excluded, 1);
  // Everybody who asks for the data from now on sees the corrected length.
  const auto after = data();
  double largest_nm = 0;
  for (std::size_t row = 0; row < after.rows; ++row)
    largest_nm = std::max(
        largest_nm, 1e6 * std::abs(after.find("x")->values[row] - before.find("x")->values[row]));
  EXPECT_NEAR(largest_nm, kCycleNm, 1);
  EXPECT_THAT(d.cell.events_named("extension.accepted").at(0), HasSubstr("correction 1"));
}

// Five rows in each line, with the run's first zero before them and a return of its own after each
// line: places 0, 6 and 12 of the dataset are passages.
TEST_F(ExtensionTest, OfAMeasuredRunNamesTheRowsOfItsPlan) {
  const RunId own = d.measured(lines_of(3, {-4, -2, 1, 3, 4}, false));
  auto wrong = outlier();
  wrong.rows = {7, 8, 12};
  findings = {wrong};
  const auto found = d.diagnosed(own, "q ~ x");
  const std::string of_run = " of run " + std::to_string(own.value);
  EXPECT_THAT(names, ElementsAre("row 1" + of_run, "row 6" + of_run, "row 11" + of_run));
  const auto json = formats::diagnosis_json(*found.found, found.origins);
  EXPECT_EQ(json.at("findings").at(0).at("rows"), (nlohmann::json{6, 7}));
  EXPECT_EQ(json.at("findings").at(0).at("row_runs"), (nlohmann::json{own.value, own.value}));
  const auto made = accept(found.record.id);
  ASSERT_TRUE(made) << made.error().message;
  ASSERT_EQ(made->excluded.size(), 1u);
  EXPECT_THAT(made->excluded[0].rows, ElementsAre(5, 6)) << "the record counts from 0";
  ASSERT_TRUE(d.cell.await(d.cell->extensions.undo(d.cell.ada, found.record.id)));
}

TEST_F(ExtensionTest, OfAModelThatMissesTheWantedAccuracyIsPromotedWithAWrittenReason) {
  findings = {bend()};
  ASSERT_TRUE(d.cell.await(d.cell->runs.tag(d.cell.ada, run, {{"wanted_a90_nm", "0.001"}}, {})));
  application::AcceptRequest request;
  request.diagnosis = d.diagnosed(run, "q ~ x").record.id;
  request.promote = request.confirmed = true;
  const auto preview = d.cell.await(d.cell->extensions.preview(request));
  ASSERT_TRUE(preview) << preview.error().message;
  EXPECT_THAT(preview->questions_for_a_reason, ElementsAre(HasSubstr("wants an A90 of 0.001 nm")));
  const auto refused = d.cell.await(d.cell->extensions.accept(d.cell.ada, request));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "REASON_REQUIRED");
  EXPECT_FALSE(d.cell.status().serving) << "nothing was made";
  request.reason = "good enough for today's test";
  const auto made = d.cell.await(d.cell->extensions.accept(d.cell.ada, request));
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_EQ(d.cell.status().serving, made->model);
  EXPECT_THAT(d.cell.events_named("note.added"),
              testing::Contains(HasSubstr("promoted, because: good enough for today's test")));
}

TEST_F(ExtensionTest, UndoneItLeavesNoTrace) {
  findings = {cycle(), outlier()};
  const auto before = *d.cell.await(d.cell->datasets.export_csv({run}, false));
  const auto id = d.diagnosed(run, "q ~ x").record.id;
  ASSERT_TRUE(accept(id));
  EXPECT_NE(*d.cell.await(d.cell->datasets.export_csv({run}, false)), before);
  const auto undone = d.cell.await(d.cell->extensions.undo(d.cell.ada, id));
  ASSERT_TRUE(undone) << undone.error().message;
  EXPECT_FALSE(undone->stands());
  EXPECT_EQ(*d.cell.await(d.cell->datasets.export_csv({run}, false)), before);  // to the byte
  EXPECT_EQ(d.cell.await(d.cell->extensions.undo(d.cell.ada, id)).error().reason, "NO_EXTENSION");
}

TEST_F(ExtensionTest, ARobotsEffectBecomesAModelThatServesAndTheOneBeforeServesAgain) {
  application::FitRequest fit;
  fit.runs = {run};
  fit.formula = "q ~ x";
  const auto parent = *d.cell.await(d.cell->models.fit(d.cell.ada, fit));
  ASSERT_TRUE(d.cell.await(d.cell->promotions.promote(d.cell.ada, parent.id, true)));
  findings = {bend()};
  application::DiagnosisRequest request;
  request.runs = {run};  // baseline: that of the model that serves
  const auto id = d.cell.await(d.cell->diagnoses.create(d.cell.ada, request))->record.id;
  d.cell.until([&] { return d.look(id).record.state == JobState::done; });
  const auto made = accept(id, {1}, true);
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_FALSE(made->correction);
  EXPECT_EQ(d.cell.status().serving, made->model);
  const auto record = *d.cell.await(d.cell->models.get(*made->model));
  EXPECT_EQ(record.parent, parent.id);
  EXPECT_THAT(record.note, HasSubstr("diagnosis 1, finding 1"));
  EXPECT_EQ(model(*made->model).formula, "q ~ x + t01");
  ASSERT_TRUE(d.cell.await(d.cell->extensions.undo(d.cell.ada, id)));
  EXPECT_EQ(d.cell.status().serving, parent.id);
}

// Two diagnoses of the same run find the same error. Accepted twice it would be taken off twice.
TEST_F(ExtensionTest, AnErrorThatIsCorrectedMeanwhileIsNotCorrectedAgain) {
  findings = {cycle()};
  const auto first = d.diagnosed(run, "q ~ x").record.id;
  const auto second = d.diagnosed(run, "q ~ x").record.id;
  d.cell.pass(1);
  ASSERT_TRUE(accept(first));
  EXPECT_THAT(accept(second).error().message,
              HasSubstr("since diagnosis 2 was made, correction 1 came into force"));
  EXPECT_FALSE(d.cell.await(d.cell->extensions.preview({second, {}, false})));
  ASSERT_TRUE(d.cell.await(d.cell->extensions.undo(d.cell.ada, first)));
  EXPECT_TRUE(accept(second)) << "the data are those that it saw";
  const auto third = d.diagnosed(run, "q ~ x").record.id;  // of corrected data
  d.cell.pass(1);
  ASSERT_TRUE(d.cell.await(d.cell->extensions.undo(d.cell.ada, second)));
  EXPECT_THAT(accept(third).error().message, HasSubstr("correction 2 was taken back"));
}

TEST_F(ExtensionTest, UndoingAllOfThemEndsAtTheModelBeforeThem) {
  application::FitRequest fit;
  fit.runs = {run};
  fit.formula = "q ~ x";
  const auto own = *d.cell.await(d.cell->models.fit(d.cell.ada, fit));
  ASSERT_TRUE(d.cell.await(d.cell->promotions.promote(d.cell.ada, own.id, true)));
  std::vector<DiagnosisId> ids;
  for (const auto* term : {"t01", "t01^2"}) {
    findings = {finding_of("thermal_offset", "t01", AppliesTo::robot, {term}, {1e-6})};
    ids.push_back(d.diagnosed(run, "q ~ x").record.id);
    const auto made = accept(ids.back(), {1}, true);
    ASSERT_TRUE(made) << made.error().message;
    EXPECT_EQ(d.cell.status().serving, made->model);
  }
  for (const auto id : ids) ASSERT_TRUE(d.cell.await(d.cell->extensions.undo(d.cell.ada, id)));
  EXPECT_EQ(d.cell.status().serving, own.id) << "not the model of the first, which is undone";
}

TEST_F(ExtensionTest, ASetThatCannotBeToldApartNeedsAChoice) {
  findings = {bend(), outlier()};
  findings[0].indistinguishable_from = {"instrument_drift"};
  const auto id = d.diagnosed(run, "q ~ x").record.id;
  const auto refused = accept(id);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "INDISTINGUISHABLE");
  EXPECT_THAT(refused.error().message, HasSubstr("instrument_drift"));
  EXPECT_TRUE(accept(id, {2}));  // the other one by itself
  EXPECT_EQ(accept(id, {1}).error().reason, "EXTENSION_STANDS");
}

// Plan of an automatic acceptance: no finding is insisted on.
TEST_F(ExtensionTest, WhatMayBeTheRobotsOrAnInstrumentsIsNotPlannedUnasked) {
  const auto columns = data();
  application::RunsData rows{columns, {}, {}};
  for (std::size_t row = 0; row < columns.rows; ++row)
    rows.origins.push_back({run, static_cast<std::int64_t>(row)});
  auto drift = finding_of("instrument_drift", "x", AppliesTo::correction, {"drift()"}, {1e-6});
  drift.indistinguishable_from = {"refractive_index x", "thermal_expansion t01"};
  auto warming = bend();
  warming.indistinguishable_from = {"thermal_lag t01"};  // the robot's as well
  auto found = diagnosis_with("q ~ x", {drift, warming});
  const auto refused = application::plan_extension(DiagnosisId{3}, found, {1}, rows);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "INDISTINGUISHABLE");
  EXPECT_THAT(refused.error().message, HasSubstr("thermal_expansion t01"));
  EXPECT_THAT(refused.error().message, testing::Not(HasSubstr("refractive_index")));
  EXPECT_THAT(application::with_known_side(found, {1, 2}, rows), ElementsAre(2));
  const auto insisted = application::plan_extension(DiagnosisId{3}, found, {1}, rows, "instrument");
  ASSERT_TRUE(insisted) << insisted.error().message;
  EXPECT_EQ(insisted->amendment.shifts.size(), 1u);
  const auto other = application::plan_extension(DiagnosisId{3}, found, {1}, rows, "backlash q1");
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().reason, "NO_SUCH_FINDING");
}

// A motor that slips shows in its own output; an instrument that jumps in all that its axis moves.
TEST_F(ExtensionTest, TheOutputsTellAJumpOfAnInstrumentFromASlipOfAMotor) {
  auto jump = finding_of("step_change", "", AppliesTo::dataset, {"step(2405 s)"}, {5e-5});
  jump.outputs.push_back(jump.outputs.front());
  jump.outputs[1].output = "q2";
  for (auto& output : jump.outputs) output.gain_2lnl = 100;
  Eigen::MatrixXd slopes(2, 2);
  slopes << 1, 0.5, 0.5, 1;  // x moves both motors, and so does y
  application::InstrumentClaim claim{{{"q1", "mm"}, {"q2", "mm"}}, {"x", "y"}, slopes, {}, {}};
  claim.seen_mm = Eigen::Vector2d(-5e-5, -2.5e-5);
  jump.outputs[1].coefficients = {-2.5e-5};
  EXPECT_EQ(application::side_of_jump(jump, claim), application::Side::instrument);
  claim.seen_mm = Eigen::Vector2d(5e-5, 1e-8);
  jump.outputs[1].coefficients = {1e-8};
  jump.outputs[1].gain_2lnl = 0;
  EXPECT_EQ(application::side_of_jump(jump, claim), application::Side::robot);
  claim.slopes = Eigen::Matrix2d::Identity();  // each motor follows one axis
  EXPECT_EQ(application::side_of_jump(jump, claim), std::nullopt);
}

TEST_F(ExtensionTest, ATermThatNoTargetCanHaveIsRefusedBeforeAnythingIsStored) {
  findings = {finding_of("cyclic_error", "q1", AppliesTo::robot, {"sin(q1, 93000 nm)"}, {1e-5})};
  const auto refused = accept(d.diagnosed(run, "q ~ x").record.id, {1});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "TERM_NOT_SERVABLE");
  EXPECT_THAT(refused.error().message, HasSubstr("sin(q1"));
  EXPECT_THAT(refused.error().message, HasSubstr("in its controller"));
  EXPECT_TRUE(d.cell.await(d.cell->models.list())->empty());
}

TEST(SideOfACause, AScaleIsTheRobotsAndACoordinateTheInstruments) {
  using application::Side;
  EXPECT_EQ(application::side_of("cyclic_error q1"), Side::robot);
  EXPECT_EQ(application::side_of("cyclic_error ma.q1"), Side::robot);
  EXPECT_EQ(application::side_of("cyclic_error x"), Side::instrument);
  EXPECT_EQ(application::side_of("refractive_index"), Side::instrument);
  EXPECT_EQ(application::side_of("thermal_rate t03"), Side::robot);
  EXPECT_EQ(application::side_of("sensor_fault t01"), Side::rows);
}

TEST_F(ExtensionTest, ACorrectionThatIsHardlyKnownIsANameAndNoMore) {
  auto tilt = finding_of("abbe_offset", "x", AppliesTo::correction, {"x^2"}, {4e-6});
  tilt.outputs[0].u90_before = 18;
  tilt.outputs[0].correction_rms = 1500;
  tilt.outputs[0].correction_u90 = 900;
  findings = {outlier(), tilt};
  const auto id = d.diagnosed(run, "q ~ x").record.id;
  const auto refused = accept(id, {2});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "UNCERTAIN_CORRECTION");
  const auto rest = accept(id);  // all of it: all that can be made
  ASSERT_TRUE(rest) << rest.error().message;
  EXPECT_EQ(rest->findings, std::vector<int>{1});

  findings[1].outputs[0].correction_u90 = 300;  // known to an eighth
  EXPECT_TRUE(accept(d.diagnosed(run, "q ~ x").record.id, {2}));
}

TEST_F(ExtensionTest, RefusesWhatIsNotThere) {
  EXPECT_EQ(accept(d.diagnosed(run, "q ~ x").record.id).error().reason, "NOTHING_FOUND");
  findings = {bend()};
  const auto id = d.diagnosed(run, "q ~ x").record.id;
  EXPECT_EQ(accept(id, {2}).error().reason, "NO_SUCH_FINDING");
  EXPECT_EQ(accept(DiagnosisId{77}).error().reason, "NO_SUCH_DIAGNOSIS");
  findings = {finding_of("noise_change", "x", AppliesTo::dataset, {}, {})};
  EXPECT_EQ(accept(d.diagnosed(run, "q ~ x").record.id).error().reason, "NOTHING_TO_MAKE");
  application::DiagnosisRequest of_file;
  of_file.csv = imported_csv();
  of_file.baseline = "q ~ x";
  findings = {bend()};
  const auto file = d.cell.await(d.cell->diagnoses.create(d.cell.ada, of_file))->record.id;
  d.cell.until([&] { return d.look(file).record.state == JobState::done; });
  EXPECT_EQ(accept(file).error().reason, "FROM_A_FILE");
}

TEST_F(ExtensionTest, ShowsBeforeAcceptingWhatChangesInWhichRunsByHowMuch) {
  // An earlier run that the diagnosis never looks at, and the run that it does.
  const RunId other = imported("last week");
  make_own(other);
  findings = {cycle(), outlier()};
  const auto before = *d.cell.await(d.cell->datasets.export_csv({other}, false));
  const auto id = d.diagnosed(run, "q ~ x").record.id;
  const auto preview = d.cell.await(d.cell->extensions.preview({id, {}, false}));
  ASSERT_TRUE(preview) << preview.error().message;
  EXPECT_EQ(preview->formula, "q ~ x");
  ASSERT_EQ(preview->changes.size(), 2u);
  EXPECT_EQ(preview->changes[0].run, run) << "what was diagnosed comes first";
  EXPECT_TRUE(preview->changes[0].diagnosed);
  EXPECT_EQ(preview->changes[0].channel, "x_mm");
  EXPECT_NEAR(preview->changes[0].largest_nm, kCycleNm, 1);
  EXPECT_NEAR(preview->changes[0].rms_nm, kCycleNm / std::sqrt(2), 2);
  EXPECT_GT(preview->changes[0].rows, 200);
  EXPECT_EQ(preview->changes[1].run, other);
  EXPECT_EQ(preview->changes[1].run_name, "last week");
  EXPECT_TRUE(preview->earlier_runs);
  EXPECT_TRUE(preview->later_runs);
  ASSERT_EQ(preview->excluded.size(), 1u);
  EXPECT_THAT(preview->sentences, testing::Contains(HasSubstr("earlier runs too")));
  EXPECT_THAT(preview->sentences, testing::Contains(HasSubstr("run 2 'last week' by up to 40")));
  // It changed nothing.
  EXPECT_EQ(*d.cell.await(d.cell->datasets.export_csv({other}, false)), before);
  EXPECT_TRUE(d.cell.await(d.cell->models.list())->empty());
  // And it told the truth.
  ASSERT_TRUE(accept(id));
  const auto after = *formats::read_dataset_csv(
      *d.cell.await(d.cell->datasets.export_csv({other}, false)), "after");
  const auto was = *formats::read_dataset_csv(before, "before");
  double largest_nm = 0;
  for (std::size_t row = 0; row < was.rows; ++row)
    largest_nm = std::max(
        largest_nm, 1e6 * std::abs(after.find("x")->values[row] - was.find("x")->values[row]));
  EXPECT_NEAR(preview->changes[1].largest_nm, largest_nm, 0.01);
  EXPECT_THAT(d.cell.events_named("extension.accepted").at(0), HasSubstr("by up to 40"));
}

TEST_F(ExtensionTest, ACorrectionFoundInAFileChangesNoRunOfThisCell) {
  const RunId stranger = imported("messung.csv");
  const auto own = exported(run), of_file = exported(stranger);
  findings = {cycle()};
  const auto id = d.diagnosed(stranger, "q ~ x").record.id;
  const auto preview = d.cell.await(d.cell->extensions.preview({id, {}, false}));
  ASSERT_TRUE(preview) << preview.error().message;
  ASSERT_EQ(preview->changes.size(), 1u);
  EXPECT_EQ(preview->changes[0].run, stranger);
  EXPECT_FALSE(preview->earlier_runs);
  EXPECT_FALSE(preview->later_runs);
  EXPECT_THAT(preview->sentences, testing::Contains(HasSubstr("the rows diagnosed are a file's")));
  ASSERT_TRUE(accept(id));
  EXPECT_EQ(exported(run).substr(exported(run).find("time_s")), own.substr(own.find("time_s")));
  EXPECT_NE(exported(stranger).substr(exported(stranger).find("time_s")),
            of_file.substr(of_file.find("time_s")));
  const auto grounds = *d.cell.await(d.cell->provenance.grounds_of_runs({run, stranger}));
  EXPECT_THAT(grounds[0].corrections, testing::IsEmpty());
  EXPECT_THAT(grounds[1].corrections, testing::SizeIs(1));
}

TEST_F(ExtensionTest, ACorrectionOfThisCellsInstrumentLeavesAFileAlone) {
  const RunId stranger = imported("messung.csv");
  const auto before = exported(stranger);
  findings = {cycle()};
  const auto id = d.diagnosed(run, "q ~ x").record.id;
  const auto preview = d.cell.await(d.cell->extensions.preview({id, {}, false}));
  ASSERT_TRUE(preview) << preview.error().message;
  EXPECT_EQ(preview->changes.size(), 1u);
  EXPECT_TRUE(preview->later_runs);
  ASSERT_TRUE(accept(id));
  const auto after = exported(stranger);
  EXPECT_EQ(after.substr(after.find("time_s")), before.substr(before.find("time_s")));
}

// A grid of 0.25 mm: 512 nm look as 1.303 mm do.
TEST_F(ExtensionTest, APeriodThatLooksLikeOthersIsAcceptedByItsNumberOnly) {
  auto wave = cycle();
  wave.parameters = {{.name = "period_nm", .value = 512.094, .aliases = {1.303e6}}};
  findings = {wave};
  const auto id = d.diagnosed(run, "q ~ x").record.id;
  const auto refused = accept(id);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "INDISTINGUISHABLE");
  EXPECT_THAT(refused.error().message, HasSubstr("looks the same as 1.303 mm"));
  EXPECT_THAT(refused.error().message, HasSubstr("--finding 1"));
  const auto preview = d.cell.await(d.cell->extensions.preview({id, {1}, false}));
  ASSERT_TRUE(preview) << preview.error().message;
  EXPECT_THAT(preview->sentences, testing::Contains(HasSubstr("looks the same as 1.303 mm")));
  EXPECT_TRUE(accept(id, {1}));
}

TEST_F(ExtensionTest, MarksRunsAndModelsThatRestOnACorrection) {
  findings = {cycle()};
  const auto id = d.diagnosed(run, "q ~ x").record.id;
  const auto made = accept(id);
  ASSERT_TRUE(made) << made.error().message;
  const auto marks = d.cell.await(d.cell->provenance.grounds_of_runs({run}))->front();
  ASSERT_EQ(marks.corrections.size(), 1u);
  EXPECT_EQ(marks.corrections[0].id, made->correction);
  ASSERT_EQ(marks.corrections[0].changes.size(), 1u);
  EXPECT_NEAR(marks.corrections[0].changes[0].largest_nm, kCycleNm, 1);
  application::FitRequest fit;
  fit.runs = {run};
  fit.formula = "q ~ x + t01";
  const auto later = *d.cell.await(d.cell->models.fit(d.cell.ada, fit));
  for (const ModelId model : {*made->model, later.id}) {
    const auto ground = *d.cell.await(d.cell->provenance.ground_of_model(model));
    ASSERT_EQ(ground.corrections.size(), 1u) << "model " << model.value;
    EXPECT_TRUE(ground.corrections[0].in_force());
    EXPECT_THAT(ground.promotion_questions, testing::Each(testing::Not(HasSubstr("correction"))));
  }
  ASSERT_TRUE(d.cell.await(d.cell->extensions.undo(d.cell.ada, id)));
  EXPECT_TRUE(d.cell.await(d.cell->provenance.grounds_of_runs({run}))->front().corrections.empty());
  // The models stay, and say what they rest on.
  EXPECT_FALSE(
      d.cell.await(d.cell->provenance.ground_of_model(later.id))->corrections[0].in_force());
  const auto refused = d.cell.await(d.cell->promotions.promote(d.cell.ada, later.id));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "NEEDS_CONFIRMATION");
  EXPECT_THAT(refused.error().message, HasSubstr("correction 1 of diagnosis 1"));
  EXPECT_THAT(refused.error().message, HasSubstr("ada took back"));
  EXPECT_TRUE(d.cell.await(d.cell->promotions.promote(d.cell.ada, later.id, true)));
  // A fit of the data as they are now rests on nothing.
  fit.formula = "q ~ x + x^2";
  const auto fresh = *d.cell.await(d.cell->models.fit(d.cell.ada, fit));
  EXPECT_TRUE(d.cell.await(d.cell->models.get(fresh.id))->corrections.empty());
}

TEST_F(ExtensionTest, RefusesAnImpossibleInstrument) {
  auto drift = finding_of("instrument_drift", "x", AppliesTo::correction, {"x:drift()"}, {-126e-6});
  findings = {drift};
  const auto refused = accept(d.diagnosed(run, "q ~ x").record.id);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "IMPOSSIBLE_PARAMETER");
  EXPECT_THAT(refused.error().message, HasSubstr("126 ppm/h"));
  EXPECT_TRUE(d.cell.await(d.cell->models.list())->empty()) << "nothing was kept";
}

// An instrument that jumps and a motor that slips read alike where one output follows one axis.
TEST_F(ExtensionTest, AJumpIsTheInstrumentsOnlyWhereSomebodySaysSo) {
  auto jump = finding_of("step_change", "", AppliesTo::dataset, {"step(2405 s)"}, {5e-5});
  jump.parameters = {{"time_s", 2405, {}, {}}};
  findings = {jump};
  const auto id = d.diagnosed(run, "q ~ x").record.id;
  const auto refused = accept(id);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "INDISTINGUISHABLE");
  EXPECT_THAT(refused.error().message, HasSubstr("a motor that slipped"));
  EXPECT_THAT(refused.error().message, HasSubstr("zero again"));
  EXPECT_THAT(refused.error().message, HasSubstr("--finding 1"));
  EXPECT_TRUE(d.cell.await(d.cell->models.list())->empty()) << "nothing was kept";
  const auto made = accept(id, {1});
  ASSERT_TRUE(made) << made.error().message;
  const auto split = data();
  ASSERT_EQ(split.datum.size(), 240u);
  EXPECT_EQ(split.datum[120], split.datum[0]);  // at 2400 s
  EXPECT_NE(split.datum[121], split.datum[0]);
}

}  // namespace
}  // namespace driftwise::tests
