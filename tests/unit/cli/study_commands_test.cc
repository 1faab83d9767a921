// Of runs at the daemon: methods side by side, the choice of thermometers, a formula before a fit,
// residuals, the correction over a plane. And a second file that validates.

#include <fmt/format.h>
#include <sys/stat.h>

#include <thread>

#include "server/core/data/row_marks.h"
#include "server/formats/csv/dataset_csv.h"
#include "tests/unit/cli/cli_fixture.h"

namespace driftwise::tests {
namespace {

class StudyCommandsTest : public CliTest {
 protected:
  StudyCommandsTest() {
    fakes.studies = &studies;
    fakes.models = &models;
  }
  FakeStudies studies;
  FakeModels models{cell};
  void a_choice() {
    cell.on_executor([&] {
      studies.choice.unit = "mm";
      calibration::SensorSet one, none;
      one.sensors = {"t04"};
      one.outputs = {{"q1", 30e-6, 0, 30e-6, {}, {}, {}}};
      one.a90_blocks_rms = 30e-6;
      none.outputs = {{"q1", 90e-6, 0, 90e-6, {}, {}, {}}};
      none.a90_blocks_rms = 90e-6;
      studies.choice.study = {{one, none}, 0, 2, 0.1};
    });
  }
};

TEST_F(StudyCommandsTest, ThermometersOfARunAreChosenAtTheDaemon) {
  a_choice();
  const auto page = run({"model", "sensors", "--run", "3", "--model", "q ~ x + T", "--threads", "2",
                         "--exclude", "t01", "--tolerance", "25"});
  EXPECT_EQ(page.exit, 0) << page.err;
  EXPECT_THAT(page.out, HasSubstr("t04   <- suffices"));
  EXPECT_THAT(page.out, HasSubstr("+60.0"));
  const auto asked = cell.on_executor([&] { return studies.last_sensors; });
  EXPECT_EQ(asked.fit.runs, std::vector{RunId{3}});
  EXPECT_EQ(asked.fit.threads, 2);
  EXPECT_EQ(asked.fit.exclude_channels, std::vector<std::string>{"t01"});
  EXPECT_EQ(asked.tolerance, 0.25);
  const auto answer = json({"model", "sensors", "--run", "3", "--model", "q ~ x + T"});
  EXPECT_EQ(answer["schema"], "driftwise.sensors.v1");
  EXPECT_EQ(answer["recommended"][0], "t04");
  EXPECT_NEAR(answer["sets"][1]["cost_nm"].get<double>(), 60, 1e-9);
}

TEST_F(StudyCommandsTest, MethodsOfARunAreComparedAtTheDaemon) {
  cell.on_executor([&] {
    identification::Judgement one;
    one.fitted.method = identification::Method::stepwise;
    one.fitted.outputs = {{"q1", "mm"}};
    identification::OutputFigures figures;
    figures.channel = {"q1", "mm"};
    figures.a90_calibration = 41e-6;
    one.outputs = {figures};
    studies.judgements = {one};
  });
  const auto robot = file("robot.toml", "[kinematics]\nkind = \"linear-axis\"\n");
  const auto page =
      run({"model", "compare", "--run", "3", "--run", "4", "--methods", "stepwise", "--kinematics",
           robot, "--together", "line", "--folds", "5", "--model", "q ~ x"});
  EXPECT_EQ(page.exit, 0) << page.err;
  EXPECT_THAT(page.out, HasSubstr("stepwise"));
  EXPECT_THAT(page.out, HasSubstr("41 nm"));
  const auto asked = cell.on_executor([&] { return studies.last_methods; });
  EXPECT_EQ(asked.fit.runs, (std::vector{RunId{3}, RunId{4}}));
  EXPECT_THAT(asked.robot, HasSubstr("linear-axis"));
  EXPECT_EQ(asked.folds, 5);
  EXPECT_EQ(json({"model", "compare", "--run", "3", "--model", "q ~ x"})["schema"],
            "driftwise.comparison.v1");
}

TEST_F(StudyCommandsTest, SaysWhatIsMissingOrTooMuch) {
  EXPECT_EQ(run({"model", "compare"}).exit, 2);
  EXPECT_EQ(run({"model", "compare", "1", "2", "--run", "3"}).exit, 2);
  const auto rows =
      run({"model", "sensors", "--run", "3", "--model", "q ~ x + T", "--exclude-rows", "4"});
  EXPECT_EQ(rows.exit, 2);
  EXPECT_THAT(rows.err, HasSubstr("driftwise data exclude"));
  EXPECT_EQ(run({"fit", "--run", "3", "--model", "q ~ x", "--validation", "x.csv"}).exit, 2);
  const auto unnamed = run({"fit", "rows.csv", "--model", "q ~ x", "--note", "after the move"});
  EXPECT_EQ(unnamed.exit, 2) << "nothing keeps the note";
  EXPECT_THAT(unnamed.err, HasSubstr("driftwise data import"));
}

TEST_F(StudyCommandsTest, TheThreadsOfAFitAreAskedFor) {
  EXPECT_EQ(run({"fit", "--run", "3", "--model", "q ~ x", "--threads", "3"}).exit, 0);
  EXPECT_EQ(cell.on_executor([&] { return models.last_fit.threads; }), 3);
}

// Held-out A90 of random points: 23.8 nm with 6, 21.9 nm with 9, 22.2 nm with 14.
TEST_F(StudyCommandsTest, NoGainIsForecastWhereTheLearningCurveDoesNotFall) {
  std::string data = "q1_mm,x_mm\n";
  for (int i = 0; i < 30; ++i) {
    const double x = 0.05 * (i * 7 % 30), noise = 4e-7 * ((i * i * 38 + i * 29) % 101 - 50);
    data += fmt::format("{:.9f},{:.4f}\n", x + noise, x);
  }
  const std::vector<std::string> points = {"model",
                                           "points",
                                           file("rows.csv", data),
                                           "--model",
                                           "q ~ x + x^2",
                                           "--sizes",
                                           "3",
                                           "--draws",
                                           "2",
                                           "--folds",
                                           "3"};
  EXPECT_THAT(run(points).out, HasSubstr("the curve does not fall at its end"));
  const auto curve = json(points);
  EXPECT_EQ(curve["gain_of_doubling"], 0);
  EXPECT_GT(curve["points"][2]["random"]["a90_nm"], curve["points"][1]["random"]["a90_nm"]);
}

TEST_F(StudyCommandsTest, AFormulaIsCheckedBeforeItIsFitted) {
  cell.on_executor([&] {
    models.formula_check.canonical = "q ~ x + T";
    models.formula_check.outputs = {"q1"};
    models.formula_check.terms = {"x", "t07"};
    models.formula_check.calibration = 40;
    models.formula_check.rank = 2;
    models.formula_check.columns = 3;
    models.formula_check.look_alikes = {"t07 cannot be told apart from 1"};
    models.formula_check.channels = {{"x", "mm"}, {"t07", "degC"}};
  });
  const auto page = run({"formula", "check", "q~x+T", "--run", "3"});
  EXPECT_EQ(page.exit, 0) << page.err;
  EXPECT_THAT(page.out, HasSubstr("terms:   x t07"));
  EXPECT_THAT(page.out, HasSubstr("2 of 3"));
  EXPECT_THAT(page.out, HasSubstr("! t07 cannot be told apart from 1"));
  EXPECT_THAT(page.out, HasSubstr("t07_degC"));
  EXPECT_EQ(json({"formula", "check", "q~x+T", "--run", "3"})["rank"], 2);
  cell.on_executor([&] { models.formula_check.problem = "unknown channel 'to7'"; });
  const auto wrong = run({"formula", "check", "q ~ to7", "--run", "3"});
  EXPECT_EQ(wrong.exit, 1);
  EXPECT_THAT(wrong.out, HasSubstr("unknown channel 'to7'"));
  EXPECT_EQ(run({"formula", "check", "q ~ x"}).exit, 2);
}

TEST_F(StudyCommandsTest, ResidualsComeAsADatasetWithWhatTheyComeTo) {
  ASSERT_EQ(run({"fit", "--run", "3", "--model", "q ~ x"}).exit, 0);
  cell.on_executor([&] {
    auto& data = models.the_residuals.data;
    data.rows = 3;
    data.time_s = {0, 10, 20};
    data.set = {PointSet::calibration, PointSet::calibration, PointSet::calibration};
    data.columns = {{{"t07", "degC"}, {20.5, 20.6, 20.7}}};
    models.the_residuals.outputs = {{{"q1", "mm"}, {1.5, -2.5, 1}, {}}};
    models.the_residuals.same_rows = true;
  });
  const auto rows = run({"model", "residuals", "1"});
  EXPECT_EQ(rows.exit, 0) << rows.err;
  EXPECT_THAT(rows.out, HasSubstr("t07_degC,q1_residual_nm"));
  EXPECT_THAT(rows.out, HasSubstr("20.6,-2.5"));
  EXPECT_THAT(rows.err, HasSubstr("-2.5"));
  EXPECT_THAT(rows.err, testing::Not(HasSubstr("not the very rows")));
  EXPECT_THAT(rows.err, HasSubstr("the fit held none out"));
  const std::string path = folder.path() + "/left.csv";
  const auto written = run({"model", "residuals", "1", "--run", "4", "-o", path});
  EXPECT_EQ(written.exit, 0);
  EXPECT_EQ(written.out, "");
  std::ifstream kept(path);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(kept), {}), rows.out);
  EXPECT_EQ(json({"model", "residuals", "1"})["outputs"][0]["unit"], "nm");
  cell.on_executor([&] { models.the_residuals.same_rows = false; });
  EXPECT_THAT(run({"model", "residuals", "1"}).err,
              testing::AllOf(HasSubstr("not the very rows that the model was fitted to"),
                             HasSubstr("no errors of held-out rows")));
}

// Row 2 of the plan, after a return of the run's own, is the third of the dataset.
TEST_F(StudyCommandsTest, ResidualsOfARunNameRowsOfThePlanAndKeepPassages) {
  ASSERT_EQ(run({"fit", "--run", "3", "--model", "q ~ x"}).exit, 0);
  cell.on_executor([&] {
    auto& of = models.the_residuals;
    of = {};
    of.data.rows = 4;
    of.data.time_s = {0, 10, 20, 30};
    of.data.zero = {0, 1, 0, 0};
    of.data.excluded = {kInUse, kPassageRow, kInUse, kExcludedRow};
    of.data.columns = {{{"t07", "degC"}, {20.5, 20.6, 20.7, 20.8}}};
    of.outputs = {{{"q1", "mm"}, {1.5, 90, -2.5, 70}, {}}};
    of.origins = {{RunId{3}, 0}, {RunId{3}, 48}, {RunId{3}, 1}, {RunId{3}, 2}};
  });
  const auto rows = run({"model", "residuals", "1"});
  EXPECT_THAT(rows.err, testing::ContainsRegex("-2\\.5 +2\n"));
  const auto written = formats::read_dataset_csv(rows.out, "residuals");
  ASSERT_TRUE(written) << written.error().message;
  EXPECT_THAT(written->excluded, testing::ElementsAre(kInUse, kPassageRow, kInUse, kExcludedRow));
  EXPECT_THAT(written->zero, testing::ElementsAre(0, 1, 0, 0));
  const auto answer = json({"model", "residuals", "1"});
  EXPECT_EQ(answer.at("rows"), (nlohmann::json{1, 49, 2, 3}));
  EXPECT_EQ(answer.at("passage"), (nlohmann::json{false, true, false, false}));
  cell.on_executor([&] { models.the_residuals.origins[3].run = RunId{4}; });
  EXPECT_THAT(run({"model", "residuals", "1"}).err, HasSubstr("2 of run 3"));
}

// The truth is q = x + 2e-5 x^2; each file is a line of its own noise.
std::string rows_of(const std::string& more_columns, const std::string& more_values, double shift) {
  std::ostringstream out;
  out << "time_s," << more_columns << "q1_mm,x_mm\n";
  for (int row = 0; row < 24; ++row) {
    const double x = -3 + 0.25 * row + shift;
    out.precision(12);
    out << row * 10 << "," << more_values << x + 2e-5 * x * x + 1e-8 * (row * 7 % 5 - 2) << "," << x
        << "\n";
  }
  return out.str();
}

TEST_F(StudyCommandsTest, ASecondFileValidatesTheFirst) {
  const auto monday = file("monday.csv", rows_of("", "", 0));
  const auto tuesday = file("tuesday.csv", rows_of("", "", 0.1));
  const auto fit =
      json({"fit", monday, "--model", "q ~ x + x^2", "--validation", tuesday, "--blocks", "0"});
  const auto alone = json({"fit", monday, "--model", "q ~ x + x^2", "--blocks", "0"});
  const auto& output = fit["outputs"]["q1"];
  EXPECT_EQ(output["u90_calibration_nm"], alone["outputs"]["q1"]["u90_calibration_nm"])
      << "the fit itself sees nothing of it";
  ASSERT_TRUE(output["u90_validation_nm"].is_number()) << fit.dump();
  EXPECT_LT(output["u90_validation_nm"].get<double>(), 50);
  EXPECT_FALSE(alone["outputs"]["q1"].contains("u90_validation_nm") &&
               alone["outputs"]["q1"]["u90_validation_nm"].is_number());
}

TEST_F(StudyCommandsTest, AValidationFileThatCannotBeHeldBesideTheFirstIsRefused) {
  const auto plain = file("plain.csv", rows_of("", "", 0));
  const auto marked = file("marked.csv", rows_of("set,", "validation,", 0));
  const auto datums = file("datums.csv", rows_of("datum,", "2,", 0.1));
  const auto other_unit = file("unit.csv", "time_s,q1_mm,x_um\n0,1,1000\n1,2,2000\n");
  const auto untimed = file("untimed.csv", "q1_mm,x_mm\n1,1\n2,2\n");
  const auto said = [&](const std::string& first, const std::string& second) {
    const auto outcome = run({"fit", first, "--model", "q ~ x", "--validation", second});
    EXPECT_EQ(outcome.exit, 3) << outcome.err;
    return outcome.err;
  };
  EXPECT_THAT(said(marked, plain), HasSubstr("marks validation rows itself"));
  EXPECT_THAT(said(plain, other_unit), HasSubstr("x is in mm"));
  EXPECT_THAT(said(plain, untimed), HasSubstr("has time_s"));
  EXPECT_THAT(said(plain, plain), HasSubstr("row")) << "the same rows hold nothing out";
  const std::string dead = rows_of("t02_degC,", ",", 0);
  EXPECT_THAT(said(file("dead.csv", dead), file("copy.csv", dead)), HasSubstr("are rows of"))
      << "also where a thermometer says nothing";
  // One datum where the other says none: they are the same.
  EXPECT_EQ(run({"fit", plain, "--model", "q ~ x", "--validation", datums}).exit, 0);
}

TEST_F(StudyCommandsTest, TermsOfTimeNeedToKnowWhenTheSecondFileBegan) {
  const auto first = file("first.csv", rows_of("", "", 0));
  const auto second = file("second.csv", rows_of("", "", 0.1));
  const auto said = [&](const std::string& one, const std::string& two, const std::string& term) {
    return run({"fit", one, "--model", "q ~ x + x^2 + " + term, "--validation", two});
  };
  for (const char* term : {"drift()", "lag(x, 60 s)", "sin_t(100 s)", "play(q1, 50 nm)"}) {
    const auto refused = said(first, second, term);
    EXPECT_EQ(refused.exit, 3) << term;
    EXPECT_THAT(refused.err, HasSubstr("# time_zero: ")) << term;
  }
  EXPECT_EQ(said(first, second, "sin(x, 316 um)").exit, 0) << "no memory";
  const auto dated = [&](const std::string& name, const std::string& hour, double shift) {
    return file(name, "# time_zero: 2026-11-30T" + hour + ":00:00Z\n" + rows_of("", "", shift));
  };
  const auto morning = dated("morning.csv", "08", 0), noon = dated("noon.csv", "12", 0.1);
  EXPECT_EQ(said(morning, noon, "drift()").exit, 0);
  EXPECT_EQ(said(morning, second, "drift()").exit, 3) << "one of them is not enough";
}

TEST_F(StudyCommandsTest, AValidationFileOfWhichNoRowCanBeJudgedIsRefused) {
  const auto warm = file("warm.csv", rows_of("t01_degC,", "20.5,", 0));
  const auto plain = file("plain.csv", rows_of("", "", 0.1));
  const auto empty = file("empty.csv", rows_of("t01_degC,", ",", 0.1));
  const auto lacking = run({"fit", warm, "--model", "q ~ x + t01", "--validation", plain});
  EXPECT_EQ(lacking.exit, 3) << lacking.out;
  EXPECT_THAT(lacking.err, HasSubstr("has no channel 't01', which the model reads"));
  for (const auto& words : {std::vector<std::string>{"fit"}, {"model", "compare"}}) {
    auto line = words;
    line.insert(line.end(), {warm, "--model", "q ~ x + t01", "--validation", empty});
    const auto none = run(line);
    EXPECT_EQ(none.exit, 3) << none.out;
    EXPECT_THAT(none.err, HasSubstr("none of its rows can be judged"));
  }
  EXPECT_EQ(run({"fit", warm, "--model", "q ~ x", "--validation", plain}).exit, 0)
      << "a channel that no term reads";
}

TEST_F(StudyCommandsTest, AValidationFileThatIsAPipeIsReadOnce) {
  const auto first = file("first.csv", rows_of("", "", 0));
  const std::string pipe = folder.path() + "/pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  std::thread writer([&] { std::ofstream(pipe) << rows_of("set,", "inside,", 0.1); });
  const auto fit = run({"fit", first, "--model", "q ~ x + x^2", "--validation", pipe});
  writer.join();
  EXPECT_EQ(fit.exit, 0) << fit.err;
  EXPECT_THAT(fit.out, HasSubstr("of them inside, 24 rows"));
  EXPECT_EQ(run({"fit", "-", "--model", "q ~ x", "--validation", "-"}).exit, 2);
}

}  // namespace
}  // namespace driftwise::tests
