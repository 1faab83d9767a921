#include "server/formats/model/model_json.h"
#include "tests/unit/cli/cli_fixture.h"

namespace driftwise::tests {
namespace {

class ModelCommandsTest : public CliTest {
 protected:
  ModelCommandsTest() {
    fakes.models = &models;
    cell.add_model("q ~ x + T");
  }
  FakeModels models{cell};
};

TEST_F(ModelCommandsTest, ShowsAPageToSign) {
  const auto page = run({"model", "show", "1"});
  EXPECT_EQ(page.exit, 0);
  for (const char* line :
       {"Model 1  first\n", "formula     q ~ x + T\n",
        "data        runs 1: 560 rows calibration, 448 validation, 0 dropped\n", " UTC by ada\n",
        "accuracy    A90 9.7 nm (q1, validation rows, mean +2 nm, S90 9.1 nm)\n",
        "A90 9.70 nm on the validation rows (mean +2.00, S90 9.10)\n",
        "q1_mm: coefficients in mm per unit of the term, 558 degrees of freedom; standard errors "
        "classical, and serial: allowing for rows that are not independent\n"})
    EXPECT_THAT(page.out, HasSubstr(line));
}

TEST_F(ModelCommandsTest, JsonCarriesTheUnitInTheKey) {
  const auto model = json({"model", "show", "1"});
  const auto& output = model["outputs"][0];
  EXPECT_NEAR(output["accuracy"]["u90_calibration_nm"].get<double>(), 8.2, 1e-9);
  EXPECT_EQ(output["accuracy"]["u90_blocks_nm"], nullptr);
  EXPECT_NEAR(output["accuracy"]["a90_validation_nm"].get<double>(), 9.7, 1e-9);
  EXPECT_NEAR(output["accuracy"]["mean_validation_nm"].get<double>(), 2.0, 1e-9);
  EXPECT_EQ(model["accuracy"][0]["rows"], "validation");
  EXPECT_NEAR(model["accuracy"][0]["figures"]["a90"].get<double>(), 9.7, 1e-9);
  EXPECT_NEAR(output["history"][0]["rmse_nm"].get<double>(), 5.0, 1e-9);
  EXPECT_TRUE(output["terms"][1].contains("contribution_rms_nm"));
  EXPECT_NEAR(model["fit_s"].get<double>(), 48.1e-6, 1e-12);
  EXPECT_TRUE(model["id"].is_number_integer());
}

TEST_F(ModelCommandsTest, PromotesComparesAndRollsBack) {
  cell.add_model("q ~ x");
  EXPECT_EQ(run({"model", "promote", "2", "--dry-run"}).exit, 0);
  EXPECT_EQ(json({"model", "list"})["models"][1]["serving"], false);
  EXPECT_EQ(run({"model", "promote", "2", "--yes"}).out,
            "model 2 serves now: q ~ x\n"
            "accuracy (A90) 9.7 nm (q1, validation rows, mean +2 nm, S90 9.1 nm)\n");
  EXPECT_THAT(run({"model", "compare", "1", "2"}).out, HasSubstr("model 2*"));
  EXPECT_EQ(run({"model", "rollback", "--yes"}).out, "no model serves now\n");
  EXPECT_EQ(json({"model", "history"})["promotions"].size(), 2U);
  EXPECT_EQ(run({"model", "promote", "9"}).exit, 3);
}

TEST_F(ModelCommandsTest, ARollbackSaysWhatItPutsBackAndAsks) {
  cell.add_model("q ~ x");
  EXPECT_EQ(run({"model", "promote", "1", "--yes"}).exit, 0);
  EXPECT_EQ(run({"model", "promote", "2", "--yes"}).exit, 0);
  const auto nobody = run({"model", "rollback"});
  EXPECT_EQ(nobody.exit, 2) << "nobody is there to be asked";
  for (const char* fact :
       {"model 2 serves no longer", "model 1 serves again: q ~ x + T\n", "accuracy (A90) 9.7 nm",
        "no run since model 1 was made shows whether the robot still does what it says", "--yes"})
    EXPECT_THAT(nobody.err, HasSubstr(fact));
  EXPECT_EQ(run({"model", "rollback"}, true, "n\n").exit, 5);
  EXPECT_EQ(json({"model", "list"})["models"][1]["serving"], true) << "nothing was changed";
  EXPECT_THAT(run({"model", "rollback"}, true, "y\n").out,
              HasSubstr("model 1 serves now: q ~ x + T\n"));
  const auto last = run({"model", "rollback"});
  EXPECT_EQ(last.exit, 2);
  EXPECT_THAT(last.err, HasSubstr("every target is refused (NO_MODEL) until one is promoted"));
  EXPECT_EQ(run({"model", "rollback", "--yes"}).out, "no model serves now\n");
  EXPECT_THAT(run({"model", "rollback"}).err, HasSubstr("there is none to take back"));
}

TEST_F(ModelCommandsTest, APromotionOfTheModelThatServesChangesNothing) {
  EXPECT_EQ(run({"model", "promote", "1", "--yes"}).exit, 0);
  const auto again = run({"model", "promote", "1"});
  EXPECT_EQ(again.exit, 0) << again.err;
  EXPECT_EQ(again.out, "model 1 serves already: nothing was changed\n");
  EXPECT_EQ(json({"model", "promote", "1"})["serves_already"], true);
  EXPECT_EQ(json({"model", "history"})["promotions"].size(), 1U);
}

// Earlier versions recorded every promotion, also of the model that served.
TEST_F(ModelCommandsTest, ARollbackPassesOverARepeatedPromotion) {
  cell.add_model("q ~ x");
  EXPECT_EQ(run({"model", "promote", "1", "--yes"}).exit, 0);
  EXPECT_EQ(run({"model", "promote", "2", "--yes"}).exit, 0);
  cell.on_store([](Store& store) {
    ASSERT_TRUE(store.models().add_promotion({ModelId{2}, kWorldBegin, "ada", "promote"}));
  });
  const auto asked = run({"model", "rollback"});
  EXPECT_THAT(asked.err, HasSubstr("model 2 serves no longer"));
  EXPECT_THAT(asked.err, HasSubstr("model 1 serves again: q ~ x + T\n"));
  EXPECT_THAT(run({"model", "rollback", "--yes"}).out, HasSubstr("model 1 serves now"));
}

// A model that rests on a correction that was taken back since.
TEST_F(ModelCommandsTest, APromotionWithAQuestionAsks) {
  cell.on_store([](Store& store) {
    DiagnosisRecord record;
    record.created = kWorldBegin;
    const auto id = store.diagnoses().add_diagnosis(record);
    ASSERT_TRUE(id && store.diagnoses().end_diagnosis(
                          id->id, {JobState::done, "", "", "{}", "", kWorldBegin}));
    auto model = store.models().model(ModelId{1});
    ASSERT_TRUE(model);
    auto whole = formats::read_model_json(model->json);
    ASSERT_TRUE(whole);
    whole->lineage.dataset_hash = "of corrected lengths";
    NewExtension fresh;
    fresh.diagnosis = id->id;
    fresh.findings = {1};
    fresh.fitted = *model;
    fresh.fitted->json = formats::write_model_json(*whole);
    fresh.fitted->hash = *formats::stored_model_hash(fresh.fitted->json);
    fresh.correction_json = "{}";
    fresh.rests_on_this = true;
    fresh.at = {kWorldBegin, 0};
    fresh.who = "ada";
    ASSERT_TRUE(store.extensions().accept(fresh));
    ASSERT_TRUE(store.extensions().undo_extension(id->id, {kWorldBegin, 1}, "ada", "", {}));
  });
  const auto nobody = run({"model", "promote", "2"});
  EXPECT_EQ(nobody.exit, 2);
  EXPECT_THAT(nobody.err, HasSubstr("correction 1"));
  EXPECT_EQ(run({"model", "promote", "2"}, true, "n\n").exit, 5);
  EXPECT_TRUE(json({"model", "history"})["promotions"].empty());
  EXPECT_EQ(run({"model", "promote", "2"}, true, "y\n").exit, 0);
  EXPECT_EQ(run({"model", "promote", "2", "--yes"}).exit, 0);
}

// Model 2: of a file of another machine, with travels that this one has not.
void add_model_of_a_file(LiveCell& cell, const RunMetadata& metadata = {}) {
  cell.on_store([&](Store& store) {
    NewRun file;
    file.metadata = metadata;
    file.name = "messung.csv";
    file.rules_json = "{}";
    file.created = {kWorldBegin, 0};
    Dataset rows;
    rows.rows = 3;
    rows.columns = {{{"q1", "mm"}, {-92, 0, 94}}, {{"x", "mm"}, {-92, 0, 94}}};
    const auto imported = store.runs().import_dataset(file, rows);
    ASSERT_TRUE(imported) << imported.error().message;
    auto record = *store.models().model(ModelId{1});
    auto model = *formats::read_model_json(record.json);
    model.lineage.runs = {imported->id};
    model.lineage.dataset_hash = "of a file";
    record.json = formats::write_model_json(model);
    record.hash = *formats::stored_model_hash(record.json);
    ASSERT_TRUE(store.models().add_model(record));
  });
}

TEST_F(ModelCommandsTest, APromotionOfAModelOfAnImportedRunAsks) {
  add_model_of_a_file(cell);
  const auto page = run({"model", "show", "2"});
  EXPECT_THAT(page.out, HasSubstr("cell file   none: not fitted from a run of this cell\n"));
  EXPECT_THAT(page.out, testing::Not(HasSubstr("Instruments, as declared")));
  EXPECT_THAT(run({"run", "show", "1"}).out,
              testing::AllOf(HasSubstr("cell file     none: its rows are a file's, imported\n"),
                             HasSubstr("trajectory    3 rows\n")));
  const auto nobody = run({"model", "promote", "2"});
  EXPECT_EQ(nobody.exit, 2);
  EXPECT_THAT(nobody.err, HasSubstr("this cell did not measure run 1 'messung.csv'"));
  EXPECT_THAT(nobody.err, HasSubstr("with q1_mm from -92 to 94, in 2 rows beyond its soft limits"));
  EXPECT_EQ(run({"model", "promote", "2", "--yes"}).exit, 0);
}

TEST_F(ModelCommandsTest, AModelThatMissesTheWantedAccuracyServesForAReasonOnly) {
  add_model_of_a_file(cell, {{"wanted_a90_nm", "5"}});
  const auto without = run({"model", "promote", "2", "--yes"});
  EXPECT_EQ(without.exit, 5);
  EXPECT_THAT(without.err, HasSubstr("wants an A90 of 5 nm and it has 9.7 nm (q1): say why"));
  EXPECT_EQ(run({"model", "promote", "2", "--yes", "--reason", " "}).exit, 5) << "a blank is none";
  EXPECT_TRUE(json({"note", "list", "--model", "2"})["notes"].empty())
      << "nothing was promoted, so there is no 'promoted, because'";
  EXPECT_EQ(run({"model", "promote", "2", "--yes", "--reason", "a trial"}).exit, 0);
  EXPECT_EQ(json({"note", "list", "--model", "2"})["notes"][0]["text"],
            "promoted, because: a trial");
}

TEST_F(ModelCommandsTest, ExportsJsonAndC) {
  EXPECT_EQ(nlohmann::json::parse(run({"model", "export", "1"}).out)["schema"],
            "driftwise.model.v1");
  const std::string path = folder.path() + "/model.c";
  EXPECT_EQ(run({"model", "export", "1", "--format", "c", "-o", path}).exit, 0);
  EXPECT_THAT(read_file(path), HasSubstr("driftwise_model_1"));
}

TEST_F(ModelCommandsTest, FitsAtTheDaemonAndPrintsTheFitsOwnJson) {
  const auto fit =
      json({"fit", "--run", "3", "--model", "q ~ x + T", "--exclude", "t01,t02", "--first", "300"});
  EXPECT_EQ(fit["schema"], "driftwise.fit.v1");
  EXPECT_EQ(fit["model_id"], 2);
  const auto asked = cell.on_executor([&] { return models.last_fit; });
  EXPECT_EQ(asked.runs, std::vector<RunId>{RunId{3}});
  EXPECT_EQ(asked.exclude_channels, (std::vector<std::string>{"t01", "t02"}));
  EXPECT_EQ(asked.first_rows, 300);
}

TEST_F(ModelCommandsTest, FitsAFileWithoutADaemon) {
  environment["DRIFTWISE_SERVER"] = "127.0.0.1:1";
  std::string csv = "q1_mm,x_mm\n";
  for (int i = 0; i < 12; ++i)
    csv += std::to_string(2 * i + (i % 3) * 0.001) + "," + std::to_string(i) + "\n";
  const auto fit = json({"fit", file("line.csv", csv), "--model", "q ~ x"});
  EXPECT_EQ(fit["rows"]["calibration"], 12);
  EXPECT_EQ(run({"fit", file("line.csv", csv), "--model", "q ~ z"}).exit, 3);
}

TEST_F(ModelCommandsTest, AsksForATarget) {
  const auto refused = run({"target", "x=1.5"});
  EXPECT_EQ(refused.exit, 5);
  EXPECT_THAT(refused.err, HasSubstr("driftwise: "));
  EXPECT_EQ(run({"target", "x=1.5", "--every", "1"}).exit, 2) << "--every needs --watch";
}

}  // namespace
}  // namespace driftwise::tests
