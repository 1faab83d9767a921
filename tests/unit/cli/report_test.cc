// The report's command against a daemon that makes the page: docs/web-report.md.

#include <filesystem>

#include "tests/unit/cli/cli_fixture.h"

namespace driftwise::tests {
namespace {

class ReportCommandTest : public CliTest {};

TEST_F(ReportCommandTest, WritesThePageThatTheDaemonMakes) {
  json({"run", "start", file("plan.csv", "x_mm\n0\n1\n0\n")});
  const auto out = file("run.html", "");
  const auto without = run({"report", "run", "1", "-o", out});
  EXPECT_EQ(without.exit, 5);
  EXPECT_THAT(without.err, HasSubstr("the page of reports was not found at "));
  std::ofstream(std::filesystem::path(cell.database()).replace_filename("report.html"))
      << "<script type=\"application/json\" id=\"report-data\">null</script>";
  const auto said = json({"report", "run", "1", "-o", out});
  EXPECT_EQ(said["run_id"], 1);
  EXPECT_GT(said["bytes"], 200);
  EXPECT_EQ(said["bytes"], std::filesystem::file_size(out));
  EXPECT_NE(run({"report", "run", "99", "-o", out}).exit, 0);
  EXPECT_NE(run({"queue", "report", "1", "-o", out}).exit, 0) << "no such entry";
}

}  // namespace
}  // namespace driftwise::tests
