// Rows kept out of fits, and notes, through the command line.

#include "tests/unit/cli/cli_fixture.h"

namespace driftwise::tests {
namespace {

class RemarkCommands : public CliTest {
 protected:
  RemarkCommands() {
    const RunId run = cell.add_run();
    PointRecord point;
    point.values = {{"q1_mm", 1.0}, {"x_mm", 1.5}};
    cell.add_points(run, std::vector<PointRecord>(60, point));
  }
};

TEST_F(RemarkCommands, KeepRowsOutWithAReason) {
  const auto said =
      run({"data", "exclude", "1", "--rows", "12,40-45", "--reason", "the door stood open"});
  EXPECT_EQ(said.exit, 0) << said.err;
  EXPECT_THAT(said.out, HasSubstr("run 1: 7 rows kept out of fits: 12,40-45  (state "));
  EXPECT_THAT(said.out, HasSubstr("ada  out   12,40-45  the door stood open"));
  const auto back =
      run({"data", "restore", "1", "--rows", "12,40-45", "--reason", "no, it did not"});
  EXPECT_THAT(back.out, HasSubstr("run 1: no row is kept out of fits"));
  const auto listed = json({"data", "exclusions", "1"});
  EXPECT_EQ(listed["history"].size(), 2u);
  EXPECT_EQ(listed["history"][0]["rows"][1]["first_row"], 40);
  EXPECT_EQ(listed["history"][1]["excluded"], false);
}

TEST_F(RemarkCommands, RefuseBadRowsAndMissingReasons) {
  const auto bad = run({"data", "exclude", "1", "--rows", "12,x", "--reason", "r"});
  EXPECT_EQ(bad.exit, 3);
  EXPECT_THAT(bad.err, HasSubstr("found 'x', expected row numbers such as 12,40-45"));
  EXPECT_EQ(run({"data", "exclude", "1", "--rows", "12"}).exit, 2);
  const auto blank = run({"data", "exclude", "1", "--rows", "12", "--reason", " "});
  EXPECT_EQ(blank.exit, 3);
  EXPECT_THAT(blank.err, HasSubstr("expected why"));
  EXPECT_EQ(run({"data", "exclusions", "7"}).exit, 3);
}

TEST_F(RemarkCommands, ShowNotesWhereTheyBelong) {
  cell.add_model("q1 ~ x");
  EXPECT_EQ(run({"note", "add", "new bearings", "--run", "1"}).exit, 0);
  EXPECT_EQ(run({"note", "add", "someone coughed", "--run", "1", "--row", "3"}).exit, 0);
  EXPECT_EQ(run({"note", "add", "signed", "--model", "1"}).exit, 0);
  EXPECT_THAT(run({"run", "show", "1"}).out, HasSubstr("ada, run 1, row 3: someone coughed"));
  EXPECT_THAT(run({"model", "show", "1"}).out, HasSubstr("ada, model 1: signed"));
  EXPECT_EQ(json({"model", "show", "1"})["notes"][0]["text"], "signed");
  EXPECT_EQ(json({"note", "list", "--run", "1"})["notes"].size(), 2u);
  EXPECT_EQ(run({"note", "add", "on nothing"}).exit, 3);
  EXPECT_EQ(run({"note", "add", "on a row", "--row", "1"}).exit, 2);
}

TEST_F(RemarkCommands, PassOnWhatAnExportAndAnImportAreToldToDo) {
  const auto lines = [](const std::string& text) { return std::ranges::count(text, '\n'); };
  const auto all = run({"data", "export", "1"}).out;
  ASSERT_EQ(run({"data", "exclude", "1", "--rows", "3-5", "--reason", "r"}).exit, 0);
  const auto without = run({"data", "export", "1", "--without-excluded"}).out;
  EXPECT_THAT(without, HasSubstr("# trajectory_rows: 1-2,6-"));
  EXPECT_EQ(lines(without), lines(all) - 3 + 1) << "that line says which rows are left";
  const auto csv = file("d.csv", "x_mm\n1\n");
  const auto first = json({"data", "import", csv, "--request-id", "7d0f"})["id"];
  EXPECT_EQ(json({"data", "import", csv, "--request-id", "7d0f"})["id"], first);
}

}  // namespace
}  // namespace driftwise::tests
