#include "clients/cli/pages/serving_text.h"

#include <gtest/gtest.h>

namespace driftwise::cli {
namespace {

TEST(ServingText, NamesTheModelAndThePlanThatServe) {
  v1::GetStatusResponse status;
  v1::ListPlansResponse plans;
  EXPECT_EQ(serving_text(status, plans), "no model: driftwise model promote N");
  for (const int id : {1, 2}) {
    auto& plan = *plans.add_plans();
    plan.set_id(id);
    plan.set_name("both");
    plan.set_serves(id == 2);
  }
  EXPECT_EQ(serving_text(status, plans), "plan 2 (both)");
  status.set_serving_model_id(3);
  EXPECT_EQ(serving_text(status, plans), "model 3, plan 2 (both)");
}

}  // namespace
}  // namespace driftwise::cli
