// The quick part of the table of lies: one channel of each kind, twice the smallest size. The whole
// table: driftwise_lies (docs/evidence/lies.md).

#include <gtest/gtest.h>

#include "tests/faults/lies/lie_table.h"

namespace driftwise::lies {
namespace {

void expect_all_found(const std::string& cell, const std::vector<std::string>& channels) {
  LieBench bench(cell);
  for (const auto& name : channels) {
    const auto found = std::ranges::find(bench.channels(), name, &ChannelOfCell::name);
    ASSERT_NE(found, bench.channels().end()) << name;
    for (const Kind kind : kKinds) {
      const auto entry = measure(bench, *found, kind, Effort::quick);
      EXPECT_EQ(entry.problem, "")
          << cell << " " << name << " " << name_of(kind) << " " << entry.size.value_or(0) << ": "
          << entry.at_twice.how << " after " << entry.at_twice.after_s
          << " s: " << entry.at_twice.said;
    }
  }
}

TEST(Lies, LinearAxis) {
  expect_all_found("linear-axis",
                   {"q1_mm", "x_mm", "air_degC", "t04_degC", "t07_degC", "support_degC"});
}
TEST(Lies, MicroNano) { expect_all_found("micro-nano", {"q2_mm", "y_mm", "ry_arcsec", "force_N"}); }

TEST(Lies, TrueDevicesRaiseNoAlarm) {
  for (const char* cell : {"linear-axis", "micro-nano"})
    EXPECT_EQ(LieBench(cell).tell_the_truth(20), std::vector<std::string>{}) << cell;
}

}  // namespace
}  // namespace driftwise::lies
