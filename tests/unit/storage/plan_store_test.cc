// Serving plans in the record.

#include "tests/unit/storage/store_fixture.h"

namespace driftwise::storage {
namespace {

class PlanStoreTest : public StoreTest {
 protected:
  PlanStoreTest() {
    ModelRecord model;
    model.name = "fine";
    model.json = "{}";
    model.hash = "aa";
    model.created = at_s(0).utc;
    model_id = store->models().add_model(model).value();
  }
  PlanRecord a_plan(const std::string& text, const std::string& request_id = "") const {
    PlanRecord plan;
    plan.name = "joint";
    plan.text = text;
    plan.hash = "hash of " + text;
    plan.models = {{model_id, "aa"}};
    plan.created = at_s(3).utc;
    plan.created_by = "ada";
    plan.created_from = "ipv4:127.0.0.1:1";
    plan.note = "first";
    plan.request_id = request_id;
    return plan;
  }
  ModelId model_id;
};

TEST_F(PlanStoreTest, CountsVersionsOfAName) {
  const auto first = store->plans().add_plan(a_plan("one")).value();
  EXPECT_EQ(first.version, 1);
  EXPECT_EQ(store->plans().add_plan(a_plan("two"))->version, 2);
  auto other = a_plan("three");
  other.name = "large";
  EXPECT_EQ(store->plans().add_plan(other)->version, 1);
  const auto kept = store->plans().plan(first.id).value();
  EXPECT_EQ(kept.text, "one");
  EXPECT_EQ(kept.models, first.models);
  EXPECT_EQ(kept.created_from, "ipv4:127.0.0.1:1");
  EXPECT_EQ(kept.note, "first");
  EXPECT_EQ(store->plans().plans()->size(), 3u);
}

TEST_F(PlanStoreTest, AnswersARepeatedCallWithThePlanThatIsThere) {
  const auto first = store->plans().add_plan(a_plan("one", "7d0f")).value();
  EXPECT_EQ(store->plans().add_plan(a_plan("one"))->id, first.id);
  EXPECT_EQ(store->plans().add_plan(a_plan("one", "7d0f"))->id, first.id);
  EXPECT_EQ(store->plans().add_plan(a_plan("two", "7d0f")).error().reason, "REQUEST_ID_REUSED");
  EXPECT_EQ(store->plans().plans()->size(), 1u);
}

TEST_F(PlanStoreTest, RefusesAPlanOfAModelThatIsNotThere) {
  auto plan = a_plan("one");
  plan.models = {{ModelId{99}, "bb"}};
  EXPECT_EQ(store->plans().add_plan(plan).error().reason, "NO_SUCH_MODEL");
  EXPECT_TRUE(store->plans().plans()->empty());
  EXPECT_EQ(store->plans().plan(PlanId{1}).error().reason, "NO_SUCH_PLAN");
}

TEST_F(PlanStoreTest, RemembersWhichPlanServed) {
  const auto plan = store->plans().add_plan(a_plan("one")).value();
  ASSERT_TRUE(store->plans().add_plan_promotion({plan.id, at_s(4).utc, "ada", "here", "promote"}));
  ASSERT_TRUE(
      store->plans().add_plan_promotion({std::nullopt, at_s(5).utc, "ada", "here", "rollback"}));
  const auto history = store->plans().plan_promotions().value();
  ASSERT_EQ(history.size(), 2u);
  EXPECT_EQ(history[0].plan, plan.id);
  EXPECT_FALSE(history[1].plan);
  EXPECT_EQ(history[1].action, "rollback");
}

}  // namespace
}  // namespace driftwise::storage
