// `driftwise data import --mapping`: shown, into a file, to the daemon.

#include "tests/unit/cli/cli_fixture.h"

namespace driftwise::tests {
namespace {

constexpr const char* kMapping =
    "[file]\nseparator = \";\"\ndecimal = \",\"\n"
    "[[column]]\nsource = \"pos\"\nunit = \"m\"\nchannel = \"x_mm\"\n"
    "[[drop]]\ncolumn = \"pos\"\nmissing = true\nwhy = \"beam broken\"\n";
constexpr const char* kTable = "pos;note\n0,5;a\n;b\n0,25;c\n";

TEST_F(CliTest, ADryRunShowsWhatAMappingMakesOfAFile) {
  environment["DRIFTWISE_SERVER"] = "127.0.0.1:1";  // no daemon is asked
  const auto shown = run({"data", "import", file("lab.csv", kTable), "--mapping",
                          file("lab.toml", kMapping), "--dry-run"});
  EXPECT_EQ(shown.exit, 0) << shown.err;
  EXPECT_THAT(shown.out, HasSubstr("3 rows read, 2 kept"));
  EXPECT_THAT(shown.out, HasSubstr("left out 1: beam broken (line 3)"));
  EXPECT_THAT(shown.out, HasSubstr("columns that no rule reads: note"));
  EXPECT_THAT(shown.out, HasSubstr("x_mm\n500\n250\n"));
  const auto report = json({"data", "import", folder.path() + "/lab.csv", "--mapping",
                            folder.path() + "/lab.toml", "--dry-run", "--rows", "1"});
  EXPECT_EQ(report.at("rows_kept"), 2);
  EXPECT_EQ(report.at("columns").at(0).at("max"), 500);
  EXPECT_THAT(report.at("first_rows_csv").get<std::string>(), testing::EndsWith("x_mm\n500\n"));
}

TEST_F(CliTest, AMappedFileBecomesADatasetFile) {
  environment["DRIFTWISE_SERVER"] = "127.0.0.1:1";
  const auto table = file("lab.csv", kTable), mapping = file("lab.toml", kMapping);
  const auto written =
      run({"data", "import", table, "--mapping", mapping, "-o", folder.path() + "/out.csv"});
  EXPECT_EQ(written.exit, 0) << written.err;
  EXPECT_EQ(written.out, "");
  EXPECT_THAT(written.err, HasSubstr("wrote "));
  const auto piped = run({"data", "import", table, "--mapping", mapping, "-o", "-"});
  EXPECT_THAT(piped.out, HasSubstr("# source: lab.csv\n"));
  EXPECT_THAT(piped.out, testing::EndsWith("x_mm\n500\n250\n"));
}

TEST_F(CliTest, AMappedFileBecomesARun) {
  const auto imported = run({"data", "import", file("lab.csv", kTable), "--mapping",
                             file("lab.toml", kMapping), "--json"});
  EXPECT_EQ(imported.exit, 0) << imported.err;
}

TEST_F(CliTest, AFileThatTheDaemonDoesNotTakeSaysHowLargeItMayBeAndWhatToDo) {
  const auto refused = run({"data", "import", file("big.csv", std::string(34 << 20, '#'))});
  EXPECT_EQ(refused.exit, 3);
  EXPECT_THAT(refused.err, testing::AllOf(HasSubstr("a dataset of 32 MiB"),
                                          HasSubstr("nothing was stored"), HasSubstr("in parts")));
}

TEST_F(CliTest, AMappingThatIsWrongExitsWith3AndNamesItsLine) {
  const auto table = file("lab.csv", kTable);
  const auto bad =
      run({"data", "import", table, "--mapping",
           file("bad.toml", "[[column]]\nsource = \"pos\"\nchannel = \"x\"\n"), "--dry-run"});
  EXPECT_EQ(bad.exit, 3);
  EXPECT_THAT(bad.err, HasSubstr("bad.toml:3: column 1: channel"));
  const auto other = run({"data", "import", file("other.csv", "position;note\n1;2\n"), "--mapping",
                          file("lab.toml", kMapping), "-o", "-"});
  EXPECT_EQ(other.exit, 3);
  EXPECT_EQ(other.out, "");
  EXPECT_THAT(other.err, HasSubstr("other.csv:1: column 1 of the mapping"));
  EXPECT_EQ(run({"data", "import", table, "--dry-run"}).exit, 2);
  EXPECT_EQ(run({"data", "import", table, "-o", "x.csv"}).exit, 2);
}

}  // namespace
}  // namespace driftwise::tests
