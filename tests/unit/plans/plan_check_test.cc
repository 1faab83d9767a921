// What stands against a plan's promotion, one mistake each.

#include "server/plans/plan_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "server/plans/step_circles.h"
#include "tests/unit/plans/two_robots.h"

namespace driftwise::plans {
namespace {

using compensation::Variable;
using testing::HasSubstr;

using Tools = std::map<ModelId, std::vector<std::string>>;

struct Case {
  ServingPlan plan = joint_plan();
  ModelsById models = joint_models();
  Tools tools;
  CellDescription cell = two_robot_cell();
};

TEST(PlanCheck, PassesTheStudysPlan) {
  const Case c;
  const auto check = check_plan(c.plan, c.models, c.tools, c.cell);
  EXPECT_TRUE(check.refusal()) << check.refusal().error().message;
  ASSERT_EQ(check.bands.size(), 1u);
  EXPECT_LT(check.bands[0].rate_share, 0.5);
  EXPECT_TRUE(check.questions().empty()) << check.questions().front();
}

struct Mistake {
  const char* name;
  std::function<void(Case&)> make;
  const char *reason, *sentence;
};
class PlanMistake : public testing::TestWithParam<Mistake> {};
TEST_P(PlanMistake, IsRefusedWithASentence) {
  Case c;
  GetParam().make(c);
  const auto refusal = check_plan(c.plan, c.models, c.tools, c.cell).refusal();
  ASSERT_FALSE(refusal);
  EXPECT_EQ(refusal.error().reason, GetParam().reason);
  EXPECT_THAT(refusal.error().message, HasSubstr(GetParam().sentence));
}

void read_tilts(Case& c) { follow_the_tilt(c.models.at(kMinAngleMotion), 2e-3); }

INSTANTIATE_TEST_SUITE_P(
    Mistakes, PlanMistake,
    testing::Values(
        Mistake{"Cycle", read_tilts, "PLAN_CYCLE",
                "step 2 (model 14) changes ma.rx_arcsec, which step 1 (model 13) reads; step 1 "
                "(model 13) changes mn.x_mm, mn.y_mm, which step 2 (model 14) reads. A pass "
                "through them "
                "leaves up to 0.02 of what was wrong before it, at most 0.01 is accepted"},
        Mistake{"Order", [](Case& c) { std::swap(c.plan.steps[0], c.plan.steps[1]); }, "PLAN_ORDER",
                "write the steps in the order 2, 1"},
        Mistake{"Unmeasured",
                [](Case& c) {
                  std::erase_if(c.cell.devices[0].become<TemperatureSettings>().probes,
                                [](const auto& probe) { return probe.channel.symbol == "t09"; });
                },
                "NOT_MEASURED", "t09_degC, which this cell does not measure"},
        Mistake{"Unwanted",
                [](Case& c) {
                  c.plan.steps[1].add = {Variable::rx, Variable::rz};
                },
                "NOT_MEASURED", "step 2 adds to ma.rz_arcsec, which no model of robot 'ma' reads"},
        Mistake{"OtherRobot", [](Case& c) { c.plan.robots[1].blend->coarse = kMicroNano; },
                "OTHER_ROBOT",
                "model 12 has channels of robot 'mn', the plan uses it as the coarse"},
        Mistake{"NoSuchModel", [](Case& c) { c.models.erase(kCoarse); }, "NO_SUCH_MODEL",
                "there is no model 10"},
        Mistake{"OtherTool",
                [](Case& c) {
                  c.plan.robots[0].tool = "diamond 3";
                  c.tools = {{kMicroNano, {"electrode"}}, {kMicroNanoTilt, {"diamond 3"}}};
                },
                "OTHER_TOOL", "model 12 was measured with tool 'electrode', robot 'mn' carries"},
        Mistake{"TwoTools",
                [](Case& c) {
                  c.tools = {{kFine, {"a"}}, {kCoarse, {"b"}}};
                },
                "OTHER_TOOL",
                "model 10 was measured with tool 'b', model 11 of the same robot with 'a'"},
        Mistake{"NobodyTakesZ", [](Case& c) { c.plan.z_taken_by.reset(); }, "AMBIGUOUS_COORDINATE",
                "robots mn, ma have z: say who takes a wanted z"},
        Mistake{"Disagreement", [](Case& c) { c.models = joint_models(200); }, "MODELS_DISAGREE",
                "(200 arcsec) at ma.z_mm ="},
        Mistake{"BandBeyondTheFineModel",
                [](Case& c) {
                  for (auto& edge : c.plan.robots[1].blend->band) edge.to = 600;
                },
                "OUTSIDE_DOMAIN", "and the fine model 11 was fitted up to"},
        Mistake{"HeightLeftOut", [](Case& c) { c.models.at(kFine) = min_angle(300, 3, 0, 1e-4); },
                "OUTSIDE_DOMAIN", "put ma.z_mm into the band"},
        Mistake{"NoOutput", [](Case& c) { c.plan.steps[0].add.push_back(Variable::z); },
                "NO_OUTPUT", "gives x, y of ma, no z"},
        Mistake{"Geometry", [](Case& c) { c.models.at(kMicroNano).geometry.emplace(); },
                "NOT_A_MOTOR_MODEL", "model 12: a robot's geometry answers single targets"},
        Mistake{"GeometryInABlend", [](Case& c) { c.models.at(kCoarse).geometry.emplace(); },
                "NOT_A_MOTOR_MODEL", "model 10: a robot's geometry answers single targets"},
        Mistake{"NoMotorModel", [](Case& c) { c.plan.robots[0].model = kMicroNanoTilt; },
                "NOT_A_MOTOR_MODEL", "model 14"}),
    [](const auto& row) { return std::string(row.param.name); });

// The fine model's z from 0 to 3 mm.
Case with_z_above_zero(BandEdge edge, double coarse_min_mm) {
  Case c;
  c.models.at(kFine).domain.back().min = 0;
  c.models.at(kFine).domain.back().max = 3;
  c.models.at(kCoarse).domain.back().min = coarse_min_mm;
  c.plan.robots[1].blend->band.push_back(edge);
  return c;
}

TEST(PlanCheck, TakesABandOverACoordinateThatWasMeasuredOnOneSideOfZero) {
  const auto refusal = [](const Case& c) -> std::string {
    const auto good = check_plan(c.plan, c.models, c.tools, c.cell).refusal();
    return good ? "" : good.error().reason + ": " + good.error().message;
  };
  const BandEdge about_zero{Variable::z, 2.5, 3.0, {}};
  EXPECT_THAT(refusal(with_z_above_zero(about_zero, -4)),
              testing::AllOf(HasSubstr("OUTSIDE_DOMAIN"), HasSubstr("side = \"above\""),
                             HasSubstr("centre = 1.5")));
  EXPECT_EQ(refusal(with_z_above_zero({Variable::z, 1.2, 1.5, {}, 1.5}, -4)), "");
  const BandEdge above{Variable::z, 2.5, 3.0, {}, 0, BandSide::above};
  EXPECT_EQ(refusal(with_z_above_zero(above, 0)), "");
  EXPECT_THAT(refusal(with_z_above_zero(above, -4)),
              testing::AllOf(HasSubstr("OUTSIDE_DOMAIN"),
                             HasSubstr("there the fine model would still answer"),
                             HasSubstr("centre = 1.5")))
      << "below zero the coarse model is known and the fine one is not";
}

TEST(PlanCheck, PassesACircleOfStepsThatSettles) {
  for (const bool turned_round : {false, true}) {
    Case c;
    follow_the_tilt(c.models.at(kMinAngleMotion), 0.9e-3);
    if (turned_round) std::swap(c.plan.steps[0], c.plan.steps[1]);
    EXPECT_TRUE(check_plan(c.plan, c.models, c.tools, c.cell).refusal());
    const auto builder = JointBuilder::create(c.plan, PlanId{1}, c.models, c.cell);
    ASSERT_TRUE(builder);
    const auto snapshot = builder->build(CellTime{1});
    EXPECT_GT(snapshot.passes, 1u);
    EXPECT_NEAR(contraction_of(snapshot), 9e-3, 1e-9);  // 10 arcsec per mm x 0.9 um per arcsec
  }
}

// x by rx, ry by x, y by ry, rx by y: what is wrong comes back to its place after two passes, and
// the two differ by the slopes' ratio.
TEST(PlanCheck, MeasuresACircleWhoseCoordinatesChangePlacesByWholeRounds) {
  for (const bool turned_round : {false, true}) {
    Case c;
    auto& motion = c.models.at(kMinAngleMotion);
    add_slope(motion.outputs[0], "ma.rx", 0.9e-3);
    add_slope(motion.outputs[1], "ma.ry", 1e-5);
    motion.domain.push_back({{"ma.rx", "arcsec"}, -300, 300});
    motion.domain.push_back({{"ma.ry", "arcsec"}, -300, 300});
    if (turned_round) std::swap(c.plan.steps[0], c.plan.steps[1]);
    const auto builder = JointBuilder::create(c.plan, PlanId{1}, c.models, c.cell);
    ASSERT_TRUE(builder);
    // Two passes leave 10 and 20 arcsec per mm times both.
    EXPECT_NEAR(contraction_of(builder->build(CellTime{1})), std::sqrt(10 * 20 * 0.9e-3 * 1e-5),
                1e-9);
  }
}

TEST(PlanCheck, GoesOnceThroughStepsThatWaitForNoneOfTheirOwn) {
  const Case c;
  const auto snapshot =
      JointBuilder::create(c.plan, PlanId{1}, c.models, c.cell)->build(CellTime{1});
  EXPECT_EQ(snapshot.passes, 1u);
  EXPECT_EQ(contraction_of(snapshot), 0);
}

TEST(PlanCheck, AsksWhereNothingSaysWhichToolItWas) {
  Case c;
  c.plan.robots[0].tool = "diamond 3";
  c.tools = {{kMicroNano, {"diamond 3"}}};
  const auto check = check_plan(c.plan, c.models, c.tools, c.cell);
  EXPECT_TRUE(check.refusal());
  ASSERT_EQ(check.questions().size(), 1u);
  EXPECT_THAT(check.questions()[0],
              HasSubstr("nothing says with which tool model 14 was measured"));
}

}  // namespace
}  // namespace driftwise::plans
