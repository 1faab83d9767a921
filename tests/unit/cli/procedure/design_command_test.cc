// The procedure and the design study over the wire; a second instrument's table; named sets.

#include <sstream>

#include "tests/unit/cli/cli_fixture.h"

namespace driftwise::tests {
namespace {

class WholeStudyTest : public CliTest {};

TEST_F(WholeStudyTest, OfANewCellNamesTheFirstCommandOfEachStep) {
  const auto page = run({"procedure"});
  EXPECT_EQ(page.exit, 1) << "nothing is wanted yet, and nothing reached";
  EXPECT_THAT(page.out, HasSubstr("1  wanted accuracy: open"));
  EXPECT_THAT(page.out, HasSubstr("> driftwise run start PLAN.csv --watch"));
  const auto answer = nlohmann::json::parse(run({"procedure", "--json"}).out);
  EXPECT_EQ(answer["schema"], "driftwise.procedure.v1");
  ASSERT_EQ(answer["steps"].size(), 6u);
  EXPECT_EQ(answer["steps"][0]["sources"][0]["name"], "geometry (lengths)");
  EXPECT_TRUE(answer["steps"][0]["sources"][0]["considered"]);
}

TEST_F(WholeStudyTest, DesignWithoutAModelSaysSo) {
  const auto page = run({"design", "--change", "x.u_length_nm=2"});
  EXPECT_EQ(page.exit, 5);
  EXPECT_THAT(page.err, HasSubstr("no model serves"));
  EXPECT_EQ(run({"design"}).exit, 2);
}

std::string plan_rows(bool with_row, double scale, double offset_mm, int first) {
  std::ostringstream csv;
  csv << (with_row ? "row_1,x_mm,y_mm,z_mm\n" : "x_mm,y_mm,z_mm\n");
  csv.precision(12);
  for (int k = 0; k < 27; ++k) {
    if (with_row) csv << k + first << ',';
    csv << offset_mm + scale * (k % 3) << ',' << scale * (k / 3 % 3) << ',' << scale * (k / 9)
        << '\n';
  }
  return csv.str();
}

TEST_F(WholeStudyTest, ASecondInstrumentIsHungOnTheRowsOfATrajectory) {
  const auto first = file("first.csv", plan_rows(false, 1, 0, 1));
  const auto second = file("second.csv", plan_rows(true, 1 + 40e-6, 0.002, 1));
  const auto answer = json({"data", "instruments", first, second});
  EXPECT_EQ(answer["schema"], "driftwise.instruments.v1");
  EXPECT_NEAR(answer["scale_ppm"].get<double>(), 40, 1e-3);
  EXPECT_NEAR(answer["offset_nm"][0].get<double>(), 2000, 1e-3);
  EXPECT_EQ(answer["residuals"].size(), 27u);
  const auto page = run({"data", "instruments", first, second});
  EXPECT_THAT(page.out, HasSubstr("scale"));
  EXPECT_THAT(page.out, HasSubstr("largest residuals"));
}

TEST_F(WholeStudyTest, ATableOfOtherRowsIsRefused) {
  const auto first = file("first.csv", plan_rows(false, 1, 0, 1));
  const auto shifted = run({"data", "instruments", first, file("s.csv", plan_rows(true, 1, 0, 2))});
  EXPECT_EQ(shifted.exit, 3);
  EXPECT_THAT(shifted.err, HasSubstr("moved by -1"));
  const auto unnamed =
      run({"data", "instruments", first, file("u.csv", plan_rows(false, 1, 0, 1))});
  EXPECT_EQ(unnamed.exit, 3);
  EXPECT_THAT(unnamed.err, HasSubstr("no column row_1"));
}

TEST_F(WholeStudyTest, ATableOfModelsHasARowForEachSetThatTheDataName) {
  std::ostringstream csv;
  csv << "set,q1_mm,x_mm,force_N\n";
  for (int k = 0; k < 60; ++k) {
    const char* set = k % 3 == 0 ? "calibration" : k % 3 == 1 ? "inside" : "warm";
    const double x = 0.1 * k, force = k % 3 == 2 ? 2 : 1;
    csv << set << ',' << 1.01 * x + 1e-6 * (k % 7) + 1e-4 * (force - 1) << ',' << x << ',' << force
        << '\n';
  }
  const auto data = file("data.csv", csv.str());
  const auto answer = json({"model", "table", data, "--model", "G: q1 ~ x"});
  ASSERT_EQ(answer["sets"].size(), 3u);
  EXPECT_EQ(answer["sets"][0]["set"], "validation");
  EXPECT_EQ(answer["sets"][0]["rows"], 40);
  EXPECT_EQ(answer["sets"][1]["set"], "inside");
  EXPECT_EQ(answer["sets"][2]["rows"], 20);
  const auto one = json({"model", "table", data, "--model", "G: q1 ~ x", "--set", "warm"});
  ASSERT_EQ(one["sets"].size(), 1u);
  EXPECT_EQ(one["sets"][0]["rows"], 20);
}

}  // namespace
}  // namespace driftwise::tests
