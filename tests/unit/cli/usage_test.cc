// What a person gets wrong, and what the world does: exit codes and sentences.

#include "tests/unit/cli/cli_fixture.h"

namespace driftwise::tests {
namespace {

TEST_F(CliTest, UsageErrorsExitWith2) {
  for (const std::vector<std::string>& line : std::vector<std::vector<std::string>>{
           {},
           {"dance"},
           {"status", "--nonsense"},
           {"run"},
           {"run", "start"},
           {"run", "show"},
           {"run", "show", "three"},
           {"run", "start", "a.csv", "--model", "3"},
           {"model", "compare", "1"},
           {"model", "export", "1", "--format", "fortran"},
           {"target"},
           {"target", "x"},
           {"target", "x=fast"},
           {"target", "x=nan"},
           {"target", "x_um=5"},
           {"target", "t07=20"},
           {"target", "x=1", "x_mm=2"},
           {"simulate", "q1_deg=10", "q1_deg=20"},
           {"simulate", "q1_deg=10", "q1_rad=0.2"},
           {"data", "export"},
           {"data", "export", "-3"},
           {"fit", "--run", "3"},
           {"fit", "--model", "q ~ x"},
           {"fit", "a.csv", "--run", "3", "--model", "q ~ x"},
           {"fit", "--run", "3", "--model", "q ~ x", "--exclude-rows", "3"},
           {"fit", "--run", "3", "--model", "q ~ x", "-o", "model.c"},
           {"fit", "a.csv", "--method", "nominal", "-o", "model.c"},
           {"status", "--timeout", "-1"}}) {
    const auto outcome = run(line);
    EXPECT_EQ(outcome.exit, 2) << testing::PrintToString(line) << outcome.err;
    EXPECT_EQ(outcome.out, "") << "data only on standard output";
    EXPECT_THAT(outcome.err, testing::StartsWith("driftwise: "));
  }
}

// A file's name, and a remark in it, by a program that writes Latin-1.
TEST_F(CliTest, JsonHoldsWhatIsNotUtf8) {
  std::string csv =
      "# instrument: Me\xdf"
      "uhr\nq1_mm,x_mm\n";
  for (int row = 0; row < 30; ++row)
    csv +=
        std::to_string(0.1 * row + 1e-6 * (row * 7 % 5)) + "," + std::to_string(0.1 * row) + "\n";
  const auto fit = run({"model", "grow", file("an\xe4.csv", csv), "--json"});
  const auto read = run({"fit", file("an\xe4.csv", csv), "--model", "q ~ x", "--json"});
  for (const auto& said : {fit, read}) {
    EXPECT_EQ(said.exit, 0) << said.err;
    EXPECT_TRUE(nlohmann::json::accept(said.out)) << said.out;
  }
}

TEST_F(CliTest, AnExceptionIsASentenceAndExitCode5) {
  std::ostringstream out, err;
  out.exceptions(std::ios::badbit);
  out.setstate(std::ios::goodbit);
  struct Broken : std::streambuf {
    int overflow(int) override { throw std::runtime_error("the tape is at its end"); }
  } broken;
  static_cast<std::ostream&>(out).rdbuf(&broken);
  cli::Console console{out, err, false, false, 80, environment, folder.path()};
  EXPECT_EQ(cli::run_cli({"completion", "bash"}, console), 5);
  EXPECT_THAT(err.str(), HasSubstr("the tape is at its end"));
}

TEST_F(CliTest, NoTrajectoryIsWrittenThatItsReaderRefuses) {
  const auto path = folder.path() + "/plan.csv";
  const auto grid = [&](const std::string& axes, const std::string& block) {
    return run({"trajectory", "grid", "--axes", axes, "--block", block, "-o", path});
  };
  EXPECT_NE(grid("q1,q1", "calibration 0:1:0.5").exit, 0);
  EXPECT_NE(grid("q1", "calibration 0:1:0.5 dwell=-5").exit, 0);
  EXPECT_NE(grid("q1", "calibration 0:1:0.5 force=nan").exit, 0);
  EXPECT_NE(run({"trajectory", "iso230-2", "--from", "0", "--to", "inf", "-o", path}).exit, 0);
  EXPECT_FALSE(std::ifstream(path).good());
  EXPECT_EQ(grid("q1", "calibration 0:1:0.5 dwell=5").exit, 0);
}

TEST_F(CliTest, ASlipInAVerbIsToldTheNearestOne) {
  EXPECT_THAT(run({"staus"}).err, HasSubstr("there is no 'staus': did you mean status?"));
  EXPECT_THAT(run({"run", "strt"}).err, HasSubstr("there is no 'strt': did you mean start?"));
}

TEST_F(CliTest, AnUnknownCommandIsNamed) {
  EXPECT_THAT(run({"dance"}).err, HasSubstr("'dance'"));
  EXPECT_THAT(run({"run", "wild"}).err, HasSubstr("'wild'"));
}

TEST_F(CliTest, AMistakeIsToldWithWhatWasFoundAndTheCommandsOwnHelp) {
  struct Row {
    std::vector<std::string> line;
    const char* sentence;
  };
  for (const Row& row :
       {Row{{"run"},
            "expected one of start, list, tag, show, watch, pause, resume, abort, confirm, verify, "
            "compare, "
            "points, "
            "attempts, datums (driftwise run --help shows the way)"},
        Row{{"fit", "--model", "q ~ x"}, "found neither a file nor --run; give one"},
        Row{{"simulate", "q1=1", "q1=2"}, "found 'q1=1' and 'q1=2', expected q1 once"},
        Row{{"run", "show"}, "RUN is required (driftwise run show --help shows the way)"},
        Row{{"run", "show", "three"}, "RUN: found 'three', expected a number"},
        Row{{"events", "--after", "-1"}, "--after: found '-1', expected a number from 0 up"},
        Row{{"status", "--timeout", "nan"},
            "--timeout: found 'nan', expected a number from 0.001 to 31536000"},
        Row{{"run", "confirm", "1", "--force", "nan"},
            "--force: found 'nan', expected a finite number"},
        Row{{"status", "--server", "localhost"},
            "--server: found 'localhost', expected host:port such as 127.0.0.1:50051"},
        Row{{"status", "--server", "127.0.0.1:70000"}, "found '127.0.0.1:70000'"}}) {
    const auto outcome = run(row.line);
    EXPECT_EQ(outcome.exit, 2);
    EXPECT_THAT(outcome.err, HasSubstr(row.sentence));
  }
}

// gRPC would send nothing, say nothing, and log a line of its own.
TEST_F(CliTest, ABinaryFileIsNoTrajectory) {
  const auto outcome = run({"trajectory", "upload", file("plan.csv", "q1_mm\n0\n\xff\xfe\n")});
  EXPECT_EQ(outcome.exit, 3);
  EXPECT_EQ(
      outcome.err,
      "driftwise: text: byte 9 is no UTF-8 text: is this the right file? If it is, save it as "
      "UTF-8\n");
}

TEST_F(CliTest, HelpOpensWithExamples) {
  const auto outcome = run({"--help"});
  EXPECT_EQ(outcome.exit, 0);
  EXPECT_THAT(outcome.out, testing::StartsWith("Examples:\n"));
  EXPECT_EQ(run({"run", "start", "--help"}).exit, 0);
  EXPECT_EQ(run({"--version"}).out, "0.1.0\n");
}

TEST_F(CliTest, BadFilesExitWith3AndAreNamed) {
  const auto missing = run({"trajectory", "check", "nowhere.csv"});
  EXPECT_EQ(missing.exit, 3);
  EXPECT_THAT(missing.err, HasSubstr("nowhere.csv"));
  EXPECT_EQ(run({"trajectory", "check", folder.path()}).exit, 3);
  const auto bad = run({"trajectory", "check", file("bad.csv", "x_mm\n0\nbad\n")});
  EXPECT_EQ(bad.exit, 3);
  EXPECT_THAT(bad.err, HasSubstr("bad.csv"));
  EXPECT_THAT(bad.err, HasSubstr("bad.csv:3: column x_mm"));
  EXPECT_EQ(run({"run", "show", "99"}).exit, 3);
}

TEST_F(CliTest, ADaemonThatIsNotThereExitsWith4AndSaysWhatToDo) {
  const auto outcome = run({"status", "--server", "127.0.0.1:1", "--timeout", "5"});
  EXPECT_EQ(outcome.exit, 4);
  EXPECT_THAT(outcome.err, HasSubstr("127.0.0.1:1"));
  EXPECT_THAT(outcome.err, HasSubstr("--server"));
}

TEST_F(CliTest, ARefusalExitsWith5) {
  const auto outcome = run({"move", "q1=99"});
  EXPECT_EQ(outcome.exit, 5);
  EXPECT_THAT(outcome.err, testing::StartsWith("driftwise: "));
}

TEST_F(CliTest, ErrorsAreJsonToo) {
  const auto outcome = run({"--json", "run", "show", "99"});
  EXPECT_EQ(outcome.exit, 3);
  const auto error = nlohmann::json::parse(outcome.err)["error"];
  EXPECT_EQ(error["code"], "not_found");
  EXPECT_EQ(error["reason"], "NO_SUCH_RUN");
}

TEST_F(CliTest, TheFlagBeatsTheEnvironmentBeatsTheFileBeatsTheDefault) {
  const std::string address = server->address();
  environment["DRIFTWISE_SERVER"] = "127.0.0.1:1";
  EXPECT_EQ(run({"devices", "--server", address}).exit, 0);
  environment["DRIFTWISE_SERVER"] = address;
  file("driftwised.json", R"({"grpc": "127.0.0.1:1"})");
  EXPECT_EQ(run({"devices"}).exit, 0);
  environment.erase("DRIFTWISE_SERVER");
  file("driftwised.json", R"({"grpc": ")" + address + R"("})");
  EXPECT_EQ(run({"devices"}).exit, 0);
  file("driftwised.json", "{");
  EXPECT_EQ(run({"devices"}).exit, 3);
}

TEST_F(CliTest, SaysWhoAsks) {
  EXPECT_EQ(run({"lease", "take", "--hold", "120", "--operator", "J\xc3\xbcrg"}).exit, 0);
  EXPECT_EQ(cell.last_event("lease.taken")->who, "J\xc3\xbcrg");
  EXPECT_THAT(run({"lease", "take", "--hold", "120"}).err, HasSubstr("J\xc3\xbcrg"));
}

TEST_F(CliTest, ColourStandsOnATerminalWithoutNoColorOnly) {
  EXPECT_THAT(run({"devices"}, true).out, HasSubstr("\x1b["));
  EXPECT_THAT(run({"devices"}).out, testing::Not(HasSubstr("\x1b[")));
  environment["NO_COLOR"] = "";
  EXPECT_THAT(run({"devices"}, true).out, testing::Not(HasSubstr("\x1b[")));
}

}  // namespace
}  // namespace driftwise::tests
