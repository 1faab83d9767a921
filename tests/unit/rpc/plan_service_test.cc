// Serving plans over gRPC on a real cell: models imported and fitted with robots' ids, a plan
// added, checked, promoted, asked, taken back; the record of it.

#include <fmt/format.h>

#include "driftwise/v1/data_service.grpc.pb.h"
#include "driftwise/v1/model_service.grpc.pb.h"
#include "driftwise/v1/plan_service.grpc.pb.h"
#include "tests/unit/rpc/rpc_fixture.h"

namespace driftwise::tests {
namespace {

using PlanStub = v1::PlanService::Stub;

class PlanServiceTest : public RpcTest {
 protected:
  // A model of data that were measured elsewhere.
  std::int64_t fitted(const std::string& csv, const std::string& formula) {
    v1::ImportDatasetRequest in;
    in.set_name("elsewhere");
    in.set_csv(csv);
    const auto run = ask(&v1::DataService::Stub::ImportDataset, in);
    EXPECT_TRUE(run) << run.error().message;
    v1::CreateFitRequest fit;
    fit.add_run_ids(run->run().id());
    fit.set_formula(formula);
    const auto model = ask(&v1::ModelService::Stub::CreateFit, fit);
    EXPECT_TRUE(model) << model.error().message;
    return model->model().id();
  }
  // mn: x, y, z each its own motor; ma: rx, ry, z; ma moves sideways with z.
  void make_models() {
    std::string mn = "mn.q1_mm,mn.q2_mm,mn.q3_mm,mn.x_mm,mn.y_mm,mn.z_mm,mn.rx_arcsec\n";
    std::string ma = "ma.q1_mm,ma.q2_mm,ma.q3_mm,ma.rx_arcsec,ma.ry_arcsec,ma.z_mm,ma.x_mm\n";
    for (int i = 0; i < 64; ++i) {
      const double a = i % 4 - 1.5, b = i / 4 % 4 - 1.5, c = i / 16 - 1.5;
      const double noise = 1e-6 * ((i * 7919) % 13 - 6);
      mn += fmt::format("{},{},{},{},{},{},{}\n", a + noise, b - noise, c + 2 * noise, a, b, c,
                        10 * b + 4 * a + 1e3 * noise);
      ma += fmt::format("{},{},{},{},{},{},{}\n", c + 0.03 * a + noise, c - 0.02 * a + 0.02 * b,
                        c - 0.01 * a - 0.03 * b - noise, 100 * a, 100 * b, c, 1e-3 * c + noise);
    }
    micro_nano = fitted(mn, "mn.q ~ poly(mn.x, mn.y, mn.z, 1)");
    tilt = fitted(mn, "mn.rx ~ poly(mn.x, mn.y, mn.z, 1)");
    min_angle = fitted(ma, "ma.q ~ poly(ma.rx, ma.ry, ma.z, 1)");
    sideways = fitted(ma, "ma.x ~ ma.z");
  }
  std::string plan_text(bool right_order = true) const {
    const std::string first = fmt::format(
        "[[parasitic]]\nmodel = {}\nfrom = \"ma\"\nto = \"mn\"\nadd = [\"x_mm\"]\n", sideways);
    const std::string second = fmt::format(
        "[[parasitic]]\nmodel = {}\nfrom = \"mn\"\nto = \"ma\"\nadd = [\"rx_arcsec\"]\n", tilt);
    return fmt::format(
               "name = \"joint\"\n[[robot]]\nid = \"mn\"\nmodel = {}\n[[robot]]\nid = \"ma\"\n"
               "model = {}\n[z]\ntaken_by = \"mn\"\n",
               micro_nano, min_angle) +
           (right_order ? first + second : second + first);
  }
  std::int64_t added(const std::string& text) {
    v1::AddPlanRequest request;
    request.set_text(text);
    const auto plan = ask(&PlanStub::AddPlan, request);
    EXPECT_TRUE(plan) << plan.error().message;
    return plan->plan().id();
  }
  v1::PromotePlanRequest promotion(std::int64_t id) const {
    v1::PromotePlanRequest request;
    request.set_plan_id(id);
    request.set_confirmed(true);  // its models are of a file
    return request;
  }
  static v1::ComputeJointTargetRequest pose() {
    v1::ComputeJointTargetRequest request;
    const std::pair<const char*, double> values[] = {{"x_mm", 1},      {"y_mm", 0.5},
                                                     {"z_mm", 0.25},   {"ma.rx_arcsec", 50},
                                                     {"ry_arcsec", 0}, {"ma.z_mm", 1}};
    for (const auto& [channel, value] : values) {
      auto& one = *request.add_pose();
      one.set_channel(channel);
      one.set_value(value);
    }
    return request;
  }
  std::int64_t micro_nano = 0, tilt = 0, min_angle = 0, sideways = 0;
};

TEST_F(PlanServiceTest, ServesAJointTargetOfAPromotedPlan) {
  EXPECT_THAT(ask(&PlanStub::ComputeJointTarget, pose()),
              FailsWith(ErrorCode::failed_precondition, "NO_PLAN"));
  make_models();
  const auto id = added(plan_text());
  EXPECT_EQ(added(plan_text()), id) << "the same text is the same plan";
  v1::CheckPlanRequest check;
  check.set_plan_id(id);
  const auto checked = ask(&PlanStub::CheckPlan, check);
  ASSERT_TRUE(checked) << checked.error().message;
  for (const auto& finding : checked->findings())
    EXPECT_FALSE(finding.refuses()) << finding.message();
  ASSERT_EQ(checked->steps_size(), 5);
  const auto promoted = ask(&PlanStub::PromotePlan, promotion(id));
  ASSERT_TRUE(promoted) << promoted.error().message;
  EXPECT_TRUE(promoted->plan().serves());
  const auto answer = ask(&PlanStub::ComputeJointTarget, pose());
  ASSERT_TRUE(answer) << answer.error().message;
  const auto& target = answer->target();
  ASSERT_EQ(target.coordinates_size(), 6);
  EXPECT_EQ(target.coordinates(0).channel(), "mn.q1_mm");
  EXPECT_NEAR(target.coordinates(0).position_mm(), 1 + 1e-3, 1e-5);  // ma stands at z = 1 mm
  ASSERT_EQ(target.terms_size(), 2);
  EXPECT_EQ(target.terms(0).from_channel(), "ma.x_mm");
  EXPECT_EQ(target.terms(0).to_channel(), "mn.x_mm");
  EXPECT_NEAR(target.terms(0).value(), 1000, 10);
  EXPECT_EQ(target.terms(0).unit(), "nm");
  EXPECT_NEAR(target.terms(1).value(), 9.004, 0.05);  // 10 arcsec per mm of y, 4 of x
  EXPECT_EQ(target.terms(1).unit(), "arcsec");
  EXPECT_NEAR(target.coordinates(3).position_mm(), 1 + 3e-4 * 59.004, 2e-5);
  for (const auto& one : target.coordinates()) EXPECT_GT(one.u_nm(), 0) << one.channel();
  EXPECT_EQ(target.robots(1).by(), v1::RobotAnswer::BY_ONE);
  EXPECT_EQ(target.plan_id(), id);
}

TEST_F(PlanServiceTest, RefusesAWrongOrderAndPutsTheRefusalOnRecord) {
  make_models();
  const auto id = added(plan_text(false));
  EXPECT_THAT(ask(&PlanStub::PromotePlan, promotion(id)),
              FailsWith(ErrorCode::failed_precondition, "PLAN_ORDER"));
  EXPECT_THAT(ask(&PlanStub::ComputeJointTarget, pose()),
              FailsWith(ErrorCode::failed_precondition, "NO_PLAN"));
  const auto refused = cell.last_event("plan.promote");
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->who, "ada");
  const auto acts = cell.on_store([](Store& store) { return store.audit().acts(0, 10).value(); });
  ASSERT_FALSE(acts.empty());
  EXPECT_THAT(acts.front().outcome, testing::HasSubstr("PLAN_ORDER: step 1 reads mn.x_mm"));
}

TEST_F(PlanServiceTest, PromotesNothingOverAPlanThatTheCallerDidNotSeeServe) {
  make_models();
  const auto first = added(plan_text());
  const auto second = added(plan_text() + "# again\n");
  const auto seen = [&](std::int64_t plan, std::int64_t serving) {
    auto request = promotion(plan);
    request.set_serving_plan_id(serving);
    return request;
  };
  ASSERT_TRUE(ask(&PlanStub::PromotePlan, seen(first, 0)));
  const auto stale = ask(&PlanStub::PromotePlan, seen(second, 0));
  EXPECT_THAT(stale, FailsWith(ErrorCode::failed_precondition, "STALE"));
  EXPECT_THAT(stale.error().message,
              testing::HasSubstr("plan 1 serves by now, where no plan was seen to serve"));
  EXPECT_TRUE(ask(&PlanStub::PromotePlan, seen(second, first)));
  EXPECT_THAT(ask(&PlanStub::PromotePlan, seen(first, first)),
              FailsWith(ErrorCode::failed_precondition, "STALE"));
}

TEST_F(PlanServiceTest, TakesAPlanBackToTheOneBefore) {
  make_models();
  const auto first = added(plan_text());
  const auto second = added(plan_text() + "# again\n");
  ASSERT_TRUE(ask(&PlanStub::PromotePlan, promotion(first)));
  ASSERT_TRUE(ask(&PlanStub::PromotePlan, promotion(second)));
  const auto listed = ask(&PlanStub::ListPlans, v1::ListPlansRequest{});
  ASSERT_TRUE(listed);
  ASSERT_EQ(listed->plans_size(), 2);
  EXPECT_FALSE(listed->plans(0).serves());
  EXPECT_TRUE(listed->plans(1).serves());
  EXPECT_EQ(listed->plans(1).version(), 2);
  EXPECT_EQ(ask(&PlanStub::RollBackPlan, v1::RollBackPlanRequest{})->plan().id(), first);
  EXPECT_FALSE(ask(&PlanStub::RollBackPlan, v1::RollBackPlanRequest{})->has_plan());
  EXPECT_THAT(ask(&PlanStub::RollBackPlan, v1::RollBackPlanRequest{}),
              FailsWith(ErrorCode::failed_precondition, "NOTHING_TO_ROLL_BACK"));
  EXPECT_THAT(ask(&PlanStub::ComputeJointTarget, pose()),
              FailsWith(ErrorCode::failed_precondition, "NO_PLAN"));
  v1::GetPlanRequest wanted;
  wanted.set_plan_id(first);
  const auto shown = ask(&PlanStub::GetPlan, wanted);
  ASSERT_TRUE(shown);
  EXPECT_EQ(shown->text(), plan_text());
  EXPECT_EQ(shown->promotions_size(), 4);
}

TEST_F(PlanServiceTest, RefusesWhatCannotBeMeant) {
  v1::AddPlanRequest request;
  request.set_text("name = \"a\"\n[[robot]]\nmodel = 99\n");
  EXPECT_THAT(ask(&PlanStub::AddPlan, request), FailsWith(ErrorCode::not_found, "NO_SUCH_MODEL"));
  request.set_text("name = ");
  EXPECT_THAT(ask(&PlanStub::AddPlan, request),
              FailsWith(ErrorCode::invalid_argument, "TOML_SYNTAX"));
  request.set_text(std::string(100'000, '#'));
  EXPECT_THAT(ask(&PlanStub::AddPlan, request), FailsWith(ErrorCode::invalid_argument, "TOO_LONG"));
  EXPECT_THAT(ask(&PlanStub::PromotePlan, promotion(9)),
              FailsWith(ErrorCode::not_found, "NO_SUCH_PLAN"));
  EXPECT_THAT(ask(&PlanStub::PromotePlan, promotion(0)),
              FailsWith(ErrorCode::invalid_argument, "BAD_ID"));
  v1::CheckPlanRequest check;
  check.set_text("name = \"a\"\n[[robot]]\nmodel = 99\n");
  const auto checked = ask(&PlanStub::CheckPlan, check);
  ASSERT_TRUE(checked) << checked.error().message;
  EXPECT_EQ(checked->findings(0).reason(), "NO_SUCH_MODEL");
}

}  // namespace
}  // namespace driftwise::tests
