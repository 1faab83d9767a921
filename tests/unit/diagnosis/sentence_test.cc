#include "server/diagnosis/report/sentence.h"

#include <gtest/gtest.h>

namespace driftwise::diagnosis {
namespace {

Finding with(const std::string& parameter, double value) {
  Finding finding{.cause = "abbe_offset", .subject = "x"};
  finding.parameters.push_back({parameter, value, {}, {}});
  finding.outputs.push_back({.output = "q1", .unit = "nm"});
  finding.outputs.push_back({.output = "x", .unit = "nm"});
  return finding;
}

bool says(const Finding& finding, const std::string& words) {
  return sentence(finding).find(", " + words) != std::string::npos;
}

TEST(Sentence, GivesEveryNumberItsUnitWhateverStandsBehindIt) {
  EXPECT_TRUE(says(with("tau_s", 1830), "tau 1830 s."));
  EXPECT_TRUE(says(with("offset_mm", 2.5), "offset 2.5 mm."));
  EXPECT_TRUE(says(with("offset_mm_rx_q1", -51.7), "offset_rx -51.7 mm (q1)."));
  EXPECT_TRUE(says(with("size_nm_x", 158), "size 158 nm (x)."));
  EXPECT_TRUE(says(with("nm_per_k_q1", 940), "940 nm_per_k (q1)."));
  EXPECT_TRUE(says(with("dead_path_mm", 12), "dead_path 12 mm."));
  EXPECT_TRUE(says(with("degree", 3), "3 degree."));
}

}  // namespace
}  // namespace driftwise::diagnosis
