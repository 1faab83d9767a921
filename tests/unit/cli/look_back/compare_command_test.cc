// Runs side by side from the command line.

#include "tests/unit/cli/cli_fixture.h"

namespace driftwise::tests {
namespace {

using CompareCommandTest = CliTest;

// The zero drifts by 0.9 um in two hours.
TEST_F(CompareCommandTest, PrintsRunsOfFilesInOtherUnitsInOneUnit) {
  for (const auto& [name, text] :
       {std::pair{"um.csv",
                  "time_s,zero,x_um,t07_degC\n0,1,0,20\n3600,1,0.3,20.5\n7200,1,0.9,21\n"},
        std::pair{"nm.csv",
                  "time_s,zero,x_nm,t07_K\n0,1,0,293\n3600,1,300,293.5\n7200,1,900,294\n"},
        std::pair{"mm.csv",
                  "time_s,zero,x_mm,t07_degC\n0,1,0,20\n3600,1,0.0003,20.5\n7200,1,0.0009,21\n"}})
    ASSERT_EQ(run({"data", "import", file(name, text)}).exit, 0) << name;
  const auto compared = run({"run", "compare", "1", "2", "3"});
  ASSERT_EQ(compared.exit, 0) << compared.err;
  EXPECT_THAT(compared.out, testing::ContainsRegex("\nx, nm +900\\.0 +\\+450\\.0 +900\\.0 "
                                                   "+\\+450\\.0 +900\\.0 +\\+450\\.0\n"));
  EXPECT_THAT(compared.out, testing::ContainsRegex("\nt07, K +1\\.000 +\\+0\\.500 +1\\.000 "
                                                   "+\\+0\\.500 +1\\.000 +\\+0\\.500\n"));
}

// A symbol may measure something else in another run.
TEST_F(CompareCommandTest, PrintsARowForEachUnitOfASymbol) {
  const auto with = [&](const char* name, const char* channel) {
    const std::string text =
        std::string("time_s,zero,") + channel + "\n0,1,0\n3600,1,1\n7200,1,2\n";
    ASSERT_EQ(run({"data", "import", file(name, text)}).exit, 0) << name;
  };
  with("length.csv", "x_nm");
  with("voltage.csv", "x_V");
  const auto compared = run({"run", "compare", "1", "2"});
  ASSERT_EQ(compared.exit, 0) << compared.err;
  EXPECT_THAT(compared.out, testing::ContainsRegex("\nx, nm +2\\.0 +\\+1\\.0 +- +-\n"));
  EXPECT_THAT(compared.out, testing::ContainsRegex("\nx, V +- +- +2\\.0 +\\+1\\.0\n"));
}

}  // namespace
}  // namespace driftwise::tests
