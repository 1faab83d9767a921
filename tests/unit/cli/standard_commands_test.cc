// `driftwise standard` and the trajectories it needs, on files.

#include <fmt/format.h>

#include "tests/unit/cli/cli_fixture.h"

namespace driftwise::tests {
namespace {

std::string standards_data(const char* name) {
  return std::string(DRIFTWISE_SOURCE_DIR) + "/tests/data/standards/" + name;
}

TEST_F(CliTest, FiguresOfAFileNeedNoDaemon) {
  environment["DRIFTWISE_SERVER"] = "127.0.0.1:1";
  const auto axis = json({"standard", "iso230-2", standards_data("iso230_2.csv")});
  EXPECT_EQ(axis.at("schema"), "driftwise.iso230-2.v1");
  EXPECT_NEAR(axis.at("a").at("both_nm").get<double>(), 375.72441745782749, 1e-8);  // by R
  EXPECT_EQ(axis.at("positions").size(), 7U);
  const auto page = run({"standard", "iso230-2", standards_data("iso230_2.csv")});
  EXPECT_THAT(page.out, HasSubstr("A        375.7"));
  EXPECT_THAT(page.out, HasSubstr("turned round at -3.5, 3.5 mm"));
  EXPECT_THAT(page.out, HasSubstr("t01_degC"));

  const auto drift =
      json({"standard", "iso230-3", standards_data("iso230_3.csv"), "--window", "30"});
  EXPECT_EQ(drift.at("series").at(0).at("windows").at(0).at("minutes"), 30);
  EXPECT_THAT(run({"standard", "iso230-3", standards_data("iso230_3.csv")}).out,
              HasSubstr("worst 60 min"));

  const auto poses = json({"standard", "iso9283", standards_data("iso9283.csv")});
  EXPECT_EQ(poses.at("poses").size(), 5U);
  EXPECT_THAT(run({"standard", "iso9283", standards_data("iso9283.csv")}).out,
              HasSubstr("5 poses, 30 cycles"));
}

TEST_F(CliTest, RowsThatAFileKeepsOutAreNoFiguresOfAStandard) {
  std::istringstream lines(read_file(standards_data("iso230_3.csv")));
  std::string kept, marked;
  int row = 0;  // of the table; 0: its head
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with('#')) continue;
    const bool out = row % 21 == 3;  // of the upper end: the axis turns round below in any case
    if (!out) kept += line + '\n';
    marked += line + (row == 0 ? ",excluded\n" : out ? ",1\n" : ",0\n");
    ++row;
  }
  const auto without = json({"standard", "iso230-3", file("kept.csv", kept)});
  EXPECT_EQ(json({"standard", "iso230-3", file("marked.csv", marked)}), without);
  EXPECT_NE(json({"standard", "iso230-3", standards_data("iso230_3.csv")}), without);
}

TEST_F(CliTest, TheAxisTurnedRoundInRowsThatAFileKeepsOutToo) {
  std::istringstream lines(read_file(standards_data("iso230_2.csv")));
  std::string marked;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with('#')) continue;
    const bool turned = line.find(",3.5,") != line.npos || line.find(",-3.5,") != line.npos;
    marked += line + (marked.empty() ? ",excluded\n" : turned ? ",1\n" : ",0\n");
  }
  const auto axis = json({"standard", "iso230-2", file("marked.csv", marked)});
  EXPECT_NEAR(axis.at("a").at("both_nm").get<double>(), 375.72441745782749, 1e-8);  // by R
  EXPECT_TRUE(axis.at("turning_points_mm").empty()) << "those rows are in no figure";
}

TEST_F(CliTest, RowsThatAFileKeepsOutAreNotCompared) {
  std::string reference = "x_mm,y_mm,z_mm,excluded\n", table = "row_1,x_mm,y_mm,z_mm\n";
  for (int row = 1; row <= 30; ++row) {
    const double x = row % 5, y = row % 3, z = row % 7;
    const bool out = row == 8;
    reference += fmt::format("{},{},{},{}\n", x + (out ? 0.05 : 0), y, z, out ? 1 : 0);
    table += fmt::format("{},{:.9f},{:.9f},{:.9f}\n", row, 1.00002 * x, 1.00002 * y, 1.00002 * z);
  }
  const auto match =
      json({"data", "instruments", file("reference.csv", reference), file("table.csv", table)});
  EXPECT_NEAR(match.at("scale_ppm").get<double>(), 20, 1e-3);
  EXPECT_EQ(match.at("rows"), 29);
}

TEST_F(CliTest, AFileThatLacksWhatAStandardNeedsIsRefusedWith5) {
  const auto lacking = run({"standard", "iso230-2", standards_data("iso230_3.csv")});
  EXPECT_EQ(lacking.exit, 5);
  EXPECT_EQ(lacking.out, "");
  EXPECT_THAT(lacking.err, HasSubstr("-4 mm has 51 from below, 0 from above"));
  EXPECT_EQ(run({"standard", "iso9283", standards_data("iso230_3.csv")}).exit, 5);
  EXPECT_EQ(run({"standard", "iso230-3", standards_data("iso230_2.csv")}).exit, 5);
  EXPECT_EQ(run({"standard", "iso230-2", file("bad.csv", "q1_mm\n0\n")}).exit, 3);
  EXPECT_EQ(run({"standard", "iso230-2"}).exit, 2);
  EXPECT_EQ(run({"standard", "iso230-2", "a.csv", "--run", "3"}).exit, 2);
}

TEST_F(CliTest, StandardTrajectoriesAreWrittenForTheirRuns) {
  const std::string path = folder.path() + "/iso.csv";
  const auto written = json({"trajectory", "iso230-2", "--from", "-4", "--to", "4", "-o", path});
  EXPECT_EQ(written.at("points"), 2 + 5 * 20);  // each pass begins with its overrun
  EXPECT_EQ(run({"trajectory", "check", path}).exit, 0);
  const auto poses = run({"trajectory", "iso9283", "--centre", "1.25,1.25,1.25", "--edge", "2"});
  EXPECT_THAT(poses.out, HasSubstr("q1_mm,q2_mm,q3_mm,set,line,zero\n0,0,0,"));
  EXPECT_THAT(poses.out, HasSubstr("\n2.05,2.05,2.05,calibration"));
  EXPECT_EQ(run({"trajectory", "iso230-3", "--at", "-4,4"}).exit, 0);
  EXPECT_EQ(run({"trajectory", "iso230-2", "--from", "4", "--to", "-4"}).exit, 3);
  EXPECT_EQ(run({"trajectory", "iso230-2", "--from", "0"}).exit, 2);
  EXPECT_EQ(run({"trajectory", "iso230-2", "--from", "0", "--to", "1", "--hold", "q2"}).exit, 2);
}

}  // namespace
}  // namespace driftwise::tests
