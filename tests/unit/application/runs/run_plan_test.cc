#include "server/application/ports/run_plan.h"

#include <gtest/gtest.h>

#include "server/core/data/reading.h"

namespace driftwise::application {
namespace {

TEST(RunPlan, ReadsBackAsItWasWritten) {
  RunPlan plan;
  plan.rules.readings_per_point = 7;
  plan.rules.max_spread_nm = 0.1;
  plan.rules.max_temperature_age_s = 1e-3;
  plan.compensate = true;
  plan.compensate_with = ModelId{12};
  plan.served_at_start = ModelId{11};
  const auto again = read_run_plan(write_run_plan(plan));
  ASSERT_TRUE(again);
  EXPECT_EQ(write_run_plan(*again), write_run_plan(plan));
  EXPECT_EQ(again->rules.max_spread_nm, 0.1);
  EXPECT_EQ(again->compensate_with, ModelId{12});
  EXPECT_EQ(again->served_at_start, ModelId{11});
}

TEST(RunPlan, KeepsDefaultsForKeysOfLaterVersions) {
  const auto plan = read_run_plan(R"({"max_rereads": 5})");
  ASSERT_TRUE(plan);
  EXPECT_EQ(plan->rules.max_rereads, 5);
  EXPECT_EQ(plan->rules.readings_per_point, RunRules{}.readings_per_point);
}

TEST(RunPlan, RefusesWhatIsNoPlan) {
  for (const char* text : {"", "[]", "{", "null", R"({"max_rereads": "two"})"})
    EXPECT_EQ(read_run_plan(text).error().reason, "BAD_RUN_PLAN") << text;
}

TEST(CheckRules, NamesTheRuleAndTheRange) {
  RunRules rules;
  rules.readings_per_point = 0;
  const auto checked = check_rules(rules);
  ASSERT_FALSE(checked);
  EXPECT_EQ(checked.error().reason, "BAD_RULES");
  EXPECT_EQ(checked.error().message, "readings_per_point = 0, expected 1 to 1000");
  rules = {};
  rules.settle_s = kMissing;
  EXPECT_FALSE(check_rules(rules));
}

}  // namespace
}  // namespace driftwise::application
