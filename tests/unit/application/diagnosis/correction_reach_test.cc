// Runs that an accepted correction holds for: those of the same instrument, and what a join took
// into its rows.

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "server/application/datasets/amended_dataset.h"
#include "server/application/datasets/instruments.h"
#include "server/application/provenance/provenance.h"
#include "server/formats/cell_file/setup_instruments.h"
#include "server/formats/csv/dataset_csv.h"
#include "storage/sqlite/database.h"
#include "tests/unit/application/diagnosis/diagnosed_cell.h"

namespace driftwise::tests {
namespace {

using effects::AppliesTo;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class CorrectionReach : public testing::Test {
 protected:
  CorrectionReach()
      : d([this](const Dataset&, const dx::DiagnoseOptions& options) -> Result<dx::Diagnosis> {
          return diagnosis_with(options.baseline.formula, findings);
        }) {}
  RunId imported(const std::string& name, const std::string& metadata, unsigned seed) {
    const auto run = d.cell.await(
        d.cell->datasets.import_csv(d.cell.ada, name, metadata + imported_csv(seed), ""));
    if (!run) throw std::runtime_error(run.error().message);
    return run->id;
  }
  // Of this cell: as a join of its own runs whose x this instrument measured.
  RunId own(const std::string& instrument, unsigned seed) {
    const auto metadata =
        instrument.empty() ? std::string() : "# measured_by: x=" + instrument + "\n";
    const RunId id = imported("own", metadata, seed);
    storage::Database(d.folder / "cell.sqlite", SQLITE_OPEN_READWRITE, "")
        .execute("UPDATE run SET rules_json = '{\"joined\":{}}' WHERE run_id = " +
                 std::to_string(id.value));
    return id;
  }
  std::string exported(RunId id) { return *d.cell.await(d.cell->datasets.export_csv({id}, false)); }
  double largest_shift_nm(const std::string& before, RunId run) {
    const auto was = *formats::read_dataset_csv(before, "before");
    const auto is = *formats::read_dataset_csv(exported(run), "now");
    double largest_nm = 0;
    for (std::size_t row = 0; row < was.rows; ++row)
      largest_nm = std::max(largest_nm,
                            1e6 * std::abs(is.find("x")->values[row] - was.find("x")->values[row]));
    return largest_nm;
  }
  DiagnosisId diagnosed(std::vector<RunId> runs) {
    application::DiagnosisRequest request;
    request.runs = std::move(runs);
    request.baseline = "q ~ x";
    const auto begun = d.cell.await(d.cell->diagnoses.create(d.cell.ada, request));
    if (!begun) throw std::runtime_error(begun.error().message);
    const auto id = begun->record.id;
    d.cell.until([&] { return d.look(id).record.state != JobState::running; });
    return id;
  }
  Result<ExtensionRecord> accept(DiagnosisId id) {
    return d.cell.await(d.cell->extensions.accept(d.cell.ada, {id, {}, false}));
  }
  std::vector<CorrectionId> over(RunId run) {
    return *d.cell.await(d.cell.read(
        [run](Store& store) { return application::corrections_over(store, std::vector{run}); }));
  }

  // Answer of the scripted search.
  std::vector<dx::Finding> findings = {finding_of("cyclic_error", "x", AppliesTo::correction,
                                                  {"sin(x, 93000 nm)", "cos(x, 93000 nm)"},
                                                  {-1.0002 * kCycleNm * 1e-6, 0})};
  DiagnosedCell d;
};

TEST_F(CorrectionReach, IsTheInstrumentThatTheErrorWasFoundIn) {
  const RunId laser = own("laser-x", 7), probe = own("probe", 8), again = own("laser-x", 9),
              unknown = own("", 10);
  const auto of_laser = exported(laser), of_probe = exported(probe), of_again = exported(again),
             of_unknown = exported(unknown);
  const auto id = diagnosed({laser});
  const auto preview = d.cell.await(d.cell->extensions.preview({id, {}, false}));
  ASSERT_TRUE(preview) << preview.error().message;
  EXPECT_THAT(preview->sentences,
              testing::Contains("and so does every run that is measured later with laser-x"));
  for (const auto& change : preview->changes) EXPECT_NE(change.run, probe);
  ASSERT_TRUE(accept(id));
  EXPECT_NEAR(largest_shift_nm(of_laser, laser), kCycleNm, 1);
  EXPECT_NEAR(largest_shift_nm(of_again, again), kCycleNm, 1);
  EXPECT_EQ(largest_shift_nm(of_probe, probe), 0);
  EXPECT_NEAR(largest_shift_nm(of_unknown, unknown), kCycleNm, 1) << "may be of the same";
  EXPECT_THAT(over(again), ElementsAre(CorrectionId{1}));
  EXPECT_THAT(over(probe), IsEmpty());
  const auto grounds = d.cell.await(d.cell->provenance.grounds_of_runs({again, probe}));
  ASSERT_TRUE(grounds);
  EXPECT_EQ(grounds->at(0).corrections.size(), 1u);
  EXPECT_THAT(grounds->at(1).corrections, IsEmpty());
}

TEST_F(CorrectionReach, OfTwoInstrumentsIsNotTold) {
  const auto id = diagnosed({own("laser-x", 7), own("probe", 8)});
  const auto refused = accept(id);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "UNCERTAIN_CORRECTION");
  EXPECT_THAT(refused.error().message,
              HasSubstr("x of the diagnosed runs was measured by laser-x and probe"));
}

TEST_F(CorrectionReach, InstrumentsAreThoseOfTheCellFile) {
  const std::string text =
      "[[device]]\nid = \"laser-x\"\nlength = \"x_mm\"\n"
      "[[device]]\nid = \"laser-z\"\nlength = \"ma.z_mm\"\n"
      "[[device]]\nid = \"touch\"\nlength = \"ma.z_mm\"\n";
  using Devices = std::map<std::string, std::string>;
  EXPECT_EQ(formats::length_instruments(text), (Devices{{"x", "laser-x"}}))
      << "ma.z is that of one or the other";
  EXPECT_EQ(formats::length_instruments("no = cell file ="), Devices());
  auto description = small_cell(d.folder / "other.sqlite");
  description.text = text;
  SmallWorld elsewhere;
  CellInMemory other(elsewhere, description, kSqlite);
  const RunId run = other.begin_run(lines_of(2, {2, -3}, true)).id;
  other.finish_run();
  const auto found = other.await(other.read(
      [run](Store& store) { return application::instruments_of(store, std::vector{run}); }));
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(*found, (application::Instruments{{"x", {"laser-x"}}}));
}

TEST_F(CorrectionReach, AnExportNamesTheCorrectionsThatAreInIt) {
  const RunId laser = own("laser-x", 7), probe = own("probe", 8);
  const RunId file = imported("elsewhere", "# place: elsewhere\n", 9);
  const auto of_probe = exported(probe), of_file = exported(file);
  ASSERT_TRUE(accept(diagnosed({laser})));
  EXPECT_THAT(exported(laser), HasSubstr("# corrections: 1\n"));
  EXPECT_EQ(exported(probe), of_probe);
  EXPECT_EQ(exported(file), of_file);
}

// A sensor that is left out of a run is left out before the run is joined.
TEST_F(CorrectionReach, AJoinKeepsTheCorrectionsThatItTookIn) {
  const auto plan = lines_of(8, {2, -3, 1, -1, 3, -2}, true);
  const RunId first = d.measured(plan), second = d.measured(plan);
  findings = {finding_of("sensor_fault", "t03", AppliesTo::dataset, {}, {})};
  const auto id = diagnosed({first});
  const auto made = accept(id);
  ASSERT_TRUE(made) << made.error().message;
  const auto joined = d.cell.await(d.cell->datasets.join(d.cell.ada, {.runs = {first, second}}));
  ASSERT_TRUE(joined) << joined.error().message;
  EXPECT_THAT(joined->report_json, HasSubstr("\"corrections\":[1]"));
  const RunId run = joined->run->id;
  application::FitRequest fit;
  fit.runs = {run};
  fit.formula = "q ~ x";
  const auto model = d.cell.await(d.cell->models.fit(d.cell.ada, fit));
  ASSERT_TRUE(model) << model.error().message;
  ASSERT_TRUE(d.cell.await(d.cell->extensions.undo(d.cell.ada, id)));
  EXPECT_THAT(over(first), IsEmpty());
  EXPECT_THAT(over(run), ElementsAre(CorrectionId{1})) << "its rows are as they were joined";
  EXPECT_THAT(exported(run), HasSubstr("# corrections: 1\n"));
  const auto grounds = d.cell.await(d.cell->provenance.grounds_of_runs({run}));
  ASSERT_TRUE(grounds);
  ASSERT_EQ(grounds->at(0).corrections.size(), 1u);
  EXPECT_FALSE(grounds->at(0).corrections[0].in_force());
  const auto ground = d.cell.await(d.cell->provenance.ground_of_model(model->id));
  ASSERT_TRUE(ground);
  EXPECT_THAT(ground->promotion_questions,
              testing::Contains(HasSubstr("correction 1 of diagnosis 1")));
}

}  // namespace
}  // namespace driftwise::tests
