// What the demos read of an exported run: its points, without the places that the run came by
// beside its plan.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "deploy/demo/figures.h"
#include "tests/support/process.h"

namespace driftwise::demo {
namespace {

using testing::ElementsAre;

// Row 2 was looked at again from aside, and measured without a value on the way.
constexpr const char* kLookedAgain =
    "# driftwise-dataset: 1\n"
    "time_s,set,line,zero,excluded,passage,q1_cmd_mm,z_mm\n"
    "0,calibration,1,1,0,0,0,0.001\n"
    "10,calibration,2,0,1,1,-4,\n"
    "11,calibration,2,0,1,1,-3.9,\n"
    "20,calibration,2,0,0,0,-4,-4.002\n"
    "30,calibration,2,0,0,0,4,4.002\n";

class ExportedRows : public testing::Test {
 protected:
  tests::TemporaryFolder folder;
  std::string file = write("looked_again.csv", kLookedAgain);

  std::string write(const std::string& name, const std::string& text) {
    const std::string path = folder.path() + "/" + name;
    std::ofstream(path) << text;
    return path;
  }
  // What the functions of set_ups.sh print.
  std::string said(const std::string& command) {
    tests::Process bash(
        {"/bin/bash", "-c",
         "set -eu; . " + std::string(DRIFTWISE_SOURCE_DIR) + "/deploy/lib/set_ups.sh; " + command});
    return bash.read_to_end(std::chrono::seconds(20));
  }
};

TEST_F(ExportedRows, AreThePointsOfTheReports) {
  const auto data = read_dataset(file);
  EXPECT_EQ(data.rows, 3U);
  EXPECT_THAT(need_column(data, "z").values, ElementsAre(0.001, -4.002, 4.002));
  EXPECT_THAT(data.line, ElementsAre(1, 2, 2));
}

TEST_F(ExportedRows, ArePairedOncePerPoint) {
  EXPECT_EQ(said("by_row z_mm " + file), "1;0;,0.001\n2;-4;,-4.002\n2;4;,4.002\n");
  EXPECT_EQ(said("column z_mm " + file), "0.001\n-4.002\n4.002\n");
}

TEST_F(ExportedRows, AreAllRowsOfAFileWithoutPassages) {
  const auto plain = write("plain.csv", "# cell: a\nline,q1_cmd_mm,z_mm\n1,0,0.001\n1,2,\n");
  EXPECT_EQ(said("by_row z_mm " + plain), "1;0;,0.001\n1;2;,\n");
  EXPECT_EQ(said("column z_mm " + plain), "0.001\n\n");
  EXPECT_EQ(read_dataset(plain).rows, 2U);
}

}  // namespace
}  // namespace driftwise::demo
