// `driftwise standard` and the trajectories it needs, on files.

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <random>

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

// 60 places at random, and what a machine with a scale of +20 ppm measures there.
struct TwoInstruments {
  std::string reference, table = "row_1,x_mm,y_mm,z_mm\n";
};

// passages: rows of the trajectory before which the run came by beside its plan. order: of the rows
// in the file.
TwoInstruments two_instruments(const std::vector<int>& passages, const std::vector<int>& order) {
  std::mt19937 random(1);
  const auto place_mm = [&random] { return 4e-6 * static_cast<double>(random() % 1'000'000) - 2; };
  std::vector<std::string> rows;
  TwoInstruments out;
  for (int row = 1; row <= 60; ++row) {
    const double x = place_mm(), y = place_mm(), z = place_mm();
    rows.push_back(fmt::format("calibration,1,0,0,0,{},{},{}\n", x, y, z));
    constexpr double kScale = 1.00002;
    out.table +=
        fmt::format("{},{:.12f},{:.12f},{:.12f}\n", row, kScale * x, kScale * y, kScale * z);
  }
  out.reference = "time_s,set,line,zero,excluded,passage,x_mm,y_mm,z_mm\n";
  int time_s = 0;
  for (const int row : order) {
    if (std::ranges::find(passages, row) != passages.end())
      out.reference += fmt::format("{},calibration,1,0,1,1,0.5,,\n", time_s++);
    out.reference += fmt::format("{},{}", time_s++, rows[static_cast<std::size_t>(row - 1)]);
  }
  return out;
}

std::vector<int> rows_from_1_to(int last) {
  std::vector<int> rows(static_cast<std::size_t>(last));
  std::iota(rows.begin(), rows.end(), 1);
  return rows;
}

TEST_F(CliTest, APlaceBesideThePlanShiftsNoRowOfASecondInstrument) {
  const auto both = two_instruments({12, 51}, rows_from_1_to(60));
  const auto reference = file("reference.csv", both.reference);
  const auto table = file("table.csv", both.table);
  const auto match = json({"data", "instruments", reference, table});
  EXPECT_NEAR(match.at("scale_ppm").get<double>(), 20, 1e-3);
  EXPECT_EQ(match.at("rows"), 60);

  const auto imported = json({"data", "import", reference});
  EXPECT_EQ(imported.at("row_count"), 60) << "a passage is no point of the run";
  EXPECT_EQ(imported.at("accepted_count"), 60);
  const auto id = std::to_string(imported.at("id").get<int>());
  const auto of_run = json({"data", "instruments", id, table});
  EXPECT_NEAR(of_run.at("scale_ppm").get<double>(), 20, 1e-3);
  EXPECT_EQ(of_run.at("rows"), 60);
  const auto exported = run({"data", "export", id});
  EXPECT_THAT(exported.out, HasSubstr(both.reference)) << "the file as it was";
}

TEST_F(CliTest, ARowThatWasMeasuredLaterKeepsItsNumberInTheTrajectory) {
  auto order = rows_from_1_to(60);
  std::ranges::rotate(order.begin() + 20, order.begin() + 21, order.begin() + 40);  // 21 after 40
  order.erase(order.begin() + 49);                                                  // 50: given up
  const auto both = two_instruments({30}, order);
  const auto table = file("table.csv", both.table);
  const auto reference =
      file("reference.csv", "# trajectory_rows: 1-20,22-40,21,41-49,51-60\n" + both.reference);
  const auto match = json({"data", "instruments", reference, table});
  EXPECT_NEAR(match.at("scale_ppm").get<double>(), 20, 1e-3);
  EXPECT_EQ(match.at("rows"), 59);
  EXPECT_EQ(match.at("table_only"), 1);

  const auto imported = std::to_string(json({"data", "import", reference}).at("id").get<int>());
  EXPECT_NEAR(json({"data", "instruments", imported, table}).at("scale_ppm").get<double>(), 20,
              1e-3);
  EXPECT_EQ(run({"data", "exclude", imported, "--rows", "20-21", "--reason", "touched"}).exit, 0);
  EXPECT_THAT(run({"data", "export", imported, "--without-excluded"}).out,
              HasSubstr("# trajectory_rows: 1-19,23-40,21,41-49,51-60\n"));
  EXPECT_EQ(json({"data", "instruments", imported, table}).at("rows"), 57);

  auto shortened = read_file(reference);
  shortened.resize(shortened.rfind("\n", shortened.size() - 2) + 1);
  const auto refused = run({"data", "instruments", file("shortened.csv", shortened), table});
  EXPECT_EQ(refused.exit, 3);
  EXPECT_THAT(refused.err, HasSubstr("names 59 rows, found 58 rows of the trajectory"));
  EXPECT_THAT(refused.err, HasSubstr("in a column row_1"));
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
  EXPECT_THAT(run({"trajectory", "iso230-2", "--axis", "mn.q1", "--from", "0", "--to", "2.5"}).out,
              HasSubstr("mn.q1_mm,set,line,zero\n0,"));
  EXPECT_EQ(run({"trajectory", "iso230-2", "--axis", "mn.q", "--from", "0", "--to", "1"}).exit, 2);
  EXPECT_EQ(run({"trajectory", "iso230-2", "--from", "4", "--to", "-4"}).exit, 3);
  EXPECT_EQ(run({"trajectory", "iso230-2", "--from", "0"}).exit, 2);
  EXPECT_EQ(run({"trajectory", "iso230-2", "--from", "0", "--to", "1", "--hold", "q2"}).exit, 2);
}

}  // namespace
}  // namespace driftwise::tests
