// Bad input by the command line: the exit code says what kind of trouble, the sentence says where,
// what was found and what was expected, and nothing is half-done.

#include <gmock/gmock.h>

#include "tests/integration/cell/cell_at_work.h"

namespace driftwise::tests {
namespace {

using testing::AllOf;
using testing::HasSubstr;

struct Case {
  std::vector<std::string> arguments;
  int exit;
  const char* reason;
  std::vector<const char*> words;
};

void expect_refused(const CellAtWork& cell, const Case& c) {
  const auto error = cell.refusal(c.arguments);
  std::string command;
  for (const auto& argument : c.arguments) command += argument + " ";
  SCOPED_TRACE(command);
  EXPECT_EQ(error.at("exit"), c.exit) << error;
  EXPECT_EQ(error.at("reason"), c.reason) << error;
  for (const char* word : c.words)
    EXPECT_THAT(error.at("message").get<std::string>(), HasSubstr(word));
}

TEST(BadInput, IsRefusedWithASentenceAndLeavesNothing) {
  CellAtWork cell;
  cell.start_daemon();
  const auto bad_number = cell.write("number.csv", "q1_mm,set\n0,calibration\n1.2.3,validation\n");
  const auto no_column = cell.write("column.csv", "speed\n1\n");
  const auto too_far = cell.write("far.csv", "q1_mm\n0\n7.5\n");
  const auto ragged = cell.write("ragged.csv", "time_s,q1_mm,x_mm\n0,1,1\n1,2\n");
  const auto pose = cell.write("pose.csv", "x_mm\n1\n");
  const std::vector<Case> cases = {
      {{"target"}, 2, "USAGE", {"pose", "x=1.5"}},
      {{"frobnicate"}, 2, "USAGE", {"frobnicate"}},
      {{"run", "start", "/nowhere/t.csv"}, 3, "NO_FILE", {"/nowhere/t.csv"}},
      {{"run", "start", bad_number}, 3, "BAD_NUMBER", {"number.csv:3", "q1_mm", "1.2.3"}},
      {{"run", "start", no_column}, 3, "UNKNOWN_COLUMN", {"column.csv", "speed"}},
      {{"trajectory", "check", too_far}, 5, "SOFT_LIMIT", {"far.csv", "7.5"}},
      {{"run", "start", too_far}, 5, "SOFT_LIMIT", {"far.csv", "7.5"}},
      {{"run", "start", pose, "--compensate"}, 5, "NO_MODEL", {"promote"}},
      {{"run", "show", "99"}, 3, "NO_SUCH_RUN", {"99"}},
      {{"data", "import", ragged}, 3, "RAGGED_ROW", {"ragged.csv:3"}},
      {{"data", "export", "99"}, 3, "NO_SUCH_RUN", {"99"}},
      {{"fit", ragged, "--model", "q ~ x"}, 3, "RAGGED_ROW", {"ragged.csv:3"}},
      {{"fit", "--run", "99", "--model", "q ~ x"}, 3, "NO_SUCH_RUN", {"99"}},
      {{"model", "promote", "99"}, 3, "NO_SUCH_MODEL", {"99"}},
      {{"target", "x=1"}, 5, "NO_MODEL", {"promote"}},
      {{"target", "x=one"}, 2, "BAD_ASSIGNMENT", {"one"}},
      {{"move", "q1=7"}, 5, "SOFT_LIMIT", {"7"}},
      {{"status", "--server", "127.0.0.1:1"}, 4, "NO_DAEMON", {"127.0.0.1:1", "driftwised"}},
  };
  for (const auto& c : cases) expect_refused(cell, c);
  EXPECT_EQ(cell.count("SELECT count(*) FROM run"), 0);
  EXPECT_EQ(cell.count("SELECT count(*) FROM model"), 0);
  EXPECT_EQ(cell.count("SELECT count(*) FROM move"), 0);
  EXPECT_FALSE(cell.ask({"lease", "show"}).contains("holder") &&
               cell.ask({"lease", "show"}).at("holder").is_string() &&
               cell.ask({"lease", "show"}).at("holder") != "")
      << "a refused run gives its lease back";
}

TEST(BadInput, ASecondRunIsRefusedWhileOneIsUnderWay) {
  CellAtWork cell;
  cell.start_daemon();
  const auto run = cell.start_run(campaign(20, 6));
  cell.wait_for_points(1);
  const auto file = cell.write("second.csv", campaign(1, 3));
  const auto error = cell.refusal({"run", "start", file});
  EXPECT_EQ(error.at("exit"), 5);
  EXPECT_EQ(error.at("code"), "failed_precondition") << error;
  EXPECT_THAT(error.at("message").get<std::string>(), HasSubstr("run 1"));
  EXPECT_EQ(cell.cli({"move", "q1=1"}).code, 5);
  EXPECT_EQ(cell.count("SELECT count(*) FROM run"), 1);
  EXPECT_EQ(cell.state_of(run), "running");
}

TEST(BadInput, TheDaemonNamesWhatIsWrongInItsCellFile) {
  const CellAtWork cell;
  const std::string daemon = std::string(DRIFTWISE_BIN_DIR) + "/driftwised";
  const auto file = cell.folder() + "/cell.toml";
  const auto start = [&] {
    return run_process({daemon, "--cell", file}, std::chrono::seconds(20));
  };
  const auto whole = read_file(file);
  cell.edit_cell_file("max_spread_nm = 5.0", "max_spread_nm = \"five\"");
  auto ended = start();
  EXPECT_EQ(ended.code, 3);
  EXPECT_THAT(ended.err, AllOf(HasSubstr("cell.toml"), HasSubstr("max_spread_nm")));
  write_file(file, whole);
  cell.edit_cell_file("kind = \"pi-gcs\"", "kind = \"pi-gsc\"");
  ended = start();
  EXPECT_EQ(ended.code, 3);
  EXPECT_THAT(ended.err, HasSubstr("pi-gsc"));
  write_file(file, whole);
  cell.edit_cell_file("[run]", "[run");
  ended = start();
  EXPECT_EQ(ended.code, 3);
  EXPECT_THAT(ended.err, HasSubstr("cell.toml"));
  EXPECT_EQ(run_process({daemon, "--cell", "/nowhere/cell.toml"}).code, 3);
}

}  // namespace
}  // namespace driftwise::tests
