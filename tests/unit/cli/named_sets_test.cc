// Names of validation sets in the daemon's own figures.

#include <cmath>

#include "tests/unit/cli/cli_fixture.h"

namespace driftwise::tests {
namespace {

class NamedSetsTest : public CliTest {};

// q1 = x, but for 100 nm in every row of "outside"; row by row another 2 nm, to and fro.
TEST_F(NamedSetsTest, OfAnImportedFileHaveFiguresOfTheirOwn) {
  std::string csv = "time_s,set,q1_nm,x_mm\n";
  for (int row = 0; row < 60; ++row)
    csv += std::to_string(20 * row) +
           (row < 30   ? ",calibration,"
            : row < 44 ? ",inside,"
                       : ",outside,") +
           std::to_string(100'000 * (row % 15) + 1'000 * row + (row >= 44 ? 100 : 0) +
                          (row % 2 ? 2 : -2)) +
           "," + std::to_string(0.1 * (row % 15) + 0.001 * row) + "\n";
  ASSERT_EQ(run({"data", "import", file("named.csv", csv)}).exit, 0);
  const auto fitted = run({"fit", "--run", "1", "--model", "q1 ~ x"});
  ASSERT_EQ(fitted.exit, 0) << fitted.err;
  const auto residuals = json({"model", "residuals", "1"});
  const auto& sets = residuals.at("outputs").at(0).at("named_sets");
  ASSERT_EQ(sets.size(), 2u) << residuals.dump(1);
  EXPECT_EQ(sets[0].at("name"), "inside");
  EXPECT_EQ(sets[0].at("figures").at("row_count"), 14);
  EXPECT_NEAR(sets[0].at("figures").at("mean").get<double>(), 0, 1);
  EXPECT_EQ(sets[1].at("name"), "outside");
  EXPECT_NEAR(sets[1].at("figures").at("mean").get<double>(), 100, 1);
  EXPECT_NEAR(sets[1].at("figures").at("a90").get<double>(), 1.645 * std::hypot(100, 2), 2);
  const auto table = run({"model", "residuals", "1"});
  EXPECT_THAT(table.out, HasSubstr(",outside,")) << "the rows keep the names";
  EXPECT_THAT(table.err, testing::ContainsRegex("q1 nm +outside +16 "));
  const auto unnamed = json({"model", "residuals", "1", "--run", "1"});
  EXPECT_EQ(unnamed.at("sets").size(), 60u);
}

std::string two_sets() {
  std::string csv = "time_s,set,q1_nm,x_mm,t01_degC\n";
  for (int row = 0; row < 60; ++row) {
    const double x_mm = 0.1 * (row % 15) + 0.001 * row, degc = 20 + 0.1 * (row * 7 % 11);
    csv += std::to_string(20 * row) +
           (row < 30   ? ",calibration,"
            : row < 44 ? ",inside,"
                       : ",outside,") +
           std::to_string(1e6 * x_mm + 300 * degc + (row >= 44 ? 100 : 0) + (row % 2 ? 2 : -2)) +
           "," + std::to_string(x_mm) + "," + std::to_string(degc) + "\n";
  }
  return csv;
}

TEST_F(NamedSetsTest, ResidualsOfAFileKeepThem) {
  const auto left = folder.path() + "/left.csv";
  const auto fit =
      run({"fit", file("two.csv", two_sets()), "--model", "q ~ x + t01", "--residuals", left});
  ASSERT_EQ(fit.exit, 0) << fit.err;
  std::ifstream kept(left);
  const std::string rows(std::istreambuf_iterator<char>(kept), {});
  EXPECT_THAT(rows, HasSubstr(",inside,"));
  EXPECT_THAT(rows, HasSubstr(",outside,"));
}

TEST_F(NamedSetsTest, AMisspeltSetIsNotAllRows) {
  const auto data = file("two.csv", two_sets());
  const auto slip = run({"model", "table", data, "--model", "G: q ~ x + t01", "--set", "insde"});
  EXPECT_EQ(slip.exit, 3);
  EXPECT_THAT(slip.err, HasSubstr("did you mean inside?"));
  EXPECT_THAT(slip.err, HasSubstr("expected one of validation, inside, outside"));
  const auto table = json({"model", "table", data, "--model", "G: q ~ x + t01", "--set", "inside",
                           "--set", "validation", "--set", "warm: t01 20.5..22"});
  EXPECT_EQ(table["sets"][0]["rows"], 14);
  EXPECT_EQ(table["sets"][1]["rows"], 30);
  EXPECT_LT(table["sets"][2]["rows"], 30);
}

}  // namespace
}  // namespace driftwise::tests
