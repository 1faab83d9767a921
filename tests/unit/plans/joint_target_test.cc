// A joint target against figure 7.20 of the study worked out by hand, and its uncertainty against
// the law of propagation.

#include "server/plans/joint_target.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/plans/two_robots.h"

namespace driftwise::plans {
namespace {

using compensation::Refusal;
using compensation::Variable;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

class JointTargets : public testing::Test {
 protected:
  JointTargets() { serve(joint_plan(), joint_models(), two_robot_cell()); }
  void serve(const ServingPlan& plan, const ModelsById& models, const CellDescription& cell) {
    auto made = JointBuilder::create(plan, PlanId{7}, models, cell);
    ASSERT_TRUE(made) << made.error().message;
    builder.emplace(std::move(*made));
    builder->anchor({}, [](ModelId) { return true; });
    const ChannelValue values[] = {{"t05_degC", 20.5}, {"t09_degC", 20.0}};
    builder->observe(values, CellTime{1});
    snapshot = builder->build(CellTime{1});
  }
  JointRequest request_of(std::initializer_list<std::pair<const char*, double>> values) const {
    JointRequest request;
    request.now = CellTime{1};
    for (const auto& [name, value] : values) {
      const auto place = joint_name(snapshot, name);
      if (!place) throw std::runtime_error(place.error().message);
      request.set(place->robot, place->variable, value);
    }
    return request;
  }
  JointTarget ask(std::initializer_list<std::pair<const char*, double>> values) const {
    return compute_joint_target(snapshot, request_of(values));
  }
  std::string refusal_of(std::initializer_list<std::pair<const char*, double>> values) const {
    const auto error = joint_refusal_error(snapshot, ask(values));
    return error.reason + ": " + error.message;
  }
  std::optional<JointBuilder> builder;
  JointSnapshot snapshot;
};

double min_angle_q(int axis, double rx, double ry, double z, double turned = 0) {
  return z +
         kRadius_mm * kRadOfArcsec *
             (std::sin(axis_angle(axis)) * (rx + turned) - std::cos(axis_angle(axis)) * ry) +
         2e-9 * rx * ry;
}

TEST_F(JointTargets, AddTheStudysTermsInTheStudysOrder) {
  const auto target = ask({{"mn.x_mm", 1.0},
                           {"mn.y_mm", -0.5},
                           {"mn.z_mm", 0.25},
                           {"ma.rx_arcsec", 0},
                           {"ma.ry_arcsec", 100},
                           {"ma.z_mm", 3}});
  ASSERT_EQ(target.refusal, Refusal::none);
  ASSERT_EQ(target.terms, 5u);
  EXPECT_NEAR(target.term[0].value, 3e-3, 1e-15);     // +3 um of ma.x at z = 3 mm, to mn.x
  EXPECT_NEAR(target.term[1].value, -2e-3, 1e-15);    // -2 um
  const double x = 1.0 + 3e-3, y = -0.5 - 2e-3;       // the tool follows the work-piece
  EXPECT_NEAR(target.term[2].value, 10 * y, 1e-12);   // mn.rx at the corrected place
  EXPECT_NEAR(target.term[3].value, -20 * x, 1e-12);  // mn.ry
  EXPECT_FALSE(target.term[4].added);                 // mn.rz is reported, never corrected
  EXPECT_NEAR(target.term[4].value, 5 * x, 1e-12);
  ASSERT_EQ(target.outputs, 6u);
  const double warm = 0.1 + 1e-3 * x * x + 2e-4 * 20.5;
  EXPECT_NEAR(target.q_mm[0], x + warm, 1e-13);
  EXPECT_NEAR(target.q_mm[1], y + warm, 1e-13);
  EXPECT_NEAR(target.q_mm[2], 0.25 + warm, 1e-13);
  for (int i = 0; i < 3; ++i)
    EXPECT_NEAR(target.q_mm[static_cast<std::size_t>(3 + i)],
                min_angle_q(i, 10 * y, 100 - 20 * x, 3), 1e-12);
  EXPECT_EQ(joint_channel(snapshot, target, 0), "mn.q1_mm");
  EXPECT_EQ(joint_channel(snapshot, target, 5), "ma.q3_mm");
  EXPECT_EQ(target.robot[1].by, AnsweredBy::fine);
}

// y' = y + dy(z) + s rx', rx' = rx + 10 y': two equations, solved by hand.
TEST_F(JointTargets, SettleWhereStepsWaitForOneAnother) {
  constexpr double kSlope = 5e-4;  // mm per arcsec: a pass leaves 0.005
  auto models = joint_models();
  follow_the_tilt(models.at(kMinAngleMotion), kSlope);
  for (const bool turned_round : {false, true}) {
    auto plan = joint_plan();
    if (turned_round) std::swap(plan.steps[0], plan.steps[1]);
    serve(plan, models, two_robot_cell());
    const auto target = ask({{"mn.x_mm", 1.0},
                             {"mn.y_mm", -0.5},
                             {"mn.z_mm", 0.25},
                             {"ma.rx_arcsec", 60},
                             {"ma.ry_arcsec", 100},
                             {"ma.z_mm", 3}});
    ASSERT_EQ(target.refusal, Refusal::none);
    const double y = (-0.5 - 2e-3 + kSlope * 60) / (1 - 10 * kSlope);
    const double rx = 60 + 10 * y;
    const double x = 1.0 + 3e-3 + kSlope * rx;
    const double warm = 0.1 + 1e-3 * x * x + 2e-4 * 20.5;
    EXPECT_NEAR(target.q_mm[0], x + warm, 1e-7);
    EXPECT_NEAR(target.q_mm[1], y + warm, 1e-7);
    for (int i = 0; i < 3; ++i)
      EXPECT_NEAR(target.q_mm[static_cast<std::size_t>(3 + i)], min_angle_q(i, rx, 100 - 20 * x, 3),
                  1e-7);
    ASSERT_EQ(target.terms, 5u);  // each once, as added at last
    EXPECT_NEAR(target.term[turned_round ? 0 : 2].value, 10 * y, 1e-5);
    // One pass would have left the first round's error.
    snapshot.passes = 1;
    EXPECT_GT(std::abs(ask({{"mn.x_mm", 1.0},
                            {"mn.y_mm", -0.5},
                            {"mn.z_mm", 0.25},
                            {"ma.rx_arcsec", 60},
                            {"ma.ry_arcsec", 100},
                            {"ma.z_mm", 3}})
                           .q_mm[1] -
                       (y + warm)),
              1e-4);
  }
}

TEST_F(JointTargets, CarryTheUncertaintyOfEachAddedTermIntoTheMotors) {
  auto alone = joint_plan();
  alone.steps.clear();
  const std::initializer_list<std::pair<const char*, double>> pose = {
      {"mn.x_mm", 1.0},    {"mn.y_mm", 0.5},    {"mn.z_mm", 0},
      {"ma.rx_arcsec", 0}, {"ma.ry_arcsec", 0}, {"ma.z_mm", 0}};
  const auto with = ask(pose);
  // Of ma.x: covariance of the constant 300 nm, residual 400 nm, t09 by 0.002 K x 100 nm/K.
  EXPECT_NEAR(with.term[0].u, std::sqrt(300.0 * 300 + 400.0 * 400 + 0.2 * 0.2), 1e-6);
  // 1e-6 arcsec where nm are of a length. The y that it reads has the u of ma.y: 10 arcsec per mm.
  EXPECT_NEAR(with.term[2].u, std::hypot(1e6 * std::hypot(0.3, 0.4), 10 * with.term[1].u), 1e-3);
  EXPECT_NEAR(with.term[3].u, std::hypot(1e6 * std::hypot(0.3, 0.4), 20 * with.term[0].u), 1e-3);
  serve(alone, joint_models(), two_robot_cell());
  const auto without = ask({{"mn.x_mm", 1.0 + with.term[0].value},
                            {"mn.y_mm", 0.5 + with.term[1].value},
                            {"mn.z_mm", 0},
                            {"ma.rx_arcsec", with.term[2].value},
                            {"ma.ry_arcsec", with.term[3].value},
                            {"ma.z_mm", 0}});
  EXPECT_NEAR(without.q_mm[4], with.q_mm[4], 1e-12);
  const double slope = 1 + 2e-3 * (1.0 + with.term[0].value);  // dq1/dx of mn
  EXPECT_NEAR(with.u_nm[0], std::hypot(without.u_nm[0], slope * with.term[0].u), 1e-6);
  const double by_rx =
      kRadius_mm * kRadOfArcsec * std::sin(axis_angle(0)) + 2e-9 * with.term[3].value;
  const double by_ry =
      -kRadius_mm * kRadOfArcsec * std::cos(axis_angle(0)) + 2e-9 * with.term[2].value;
  EXPECT_NEAR(with.u_nm[3],
              std::sqrt(without.u_nm[3] * without.u_nm[3] + std::pow(by_rx * with.term[2].u, 2) +
                        std::pow(by_ry * with.term[3].u, 2)),
              1e-6);
}

TEST_F(JointTargets, OfABlendHoldTheDisagreementOfItsModels) {
  auto plan = joint_plan();
  plan.steps.clear();
  serve(plan, joint_models(3), two_robot_cell());
  const std::initializer_list<std::pair<const char*, double>> in_band = {
      {"mn.x_mm", 0},        {"mn.y_mm", 0},      {"mn.z_mm", 0},
      {"ma.rx_arcsec", 325}, {"ma.ry_arcsec", 0}, {"ma.z_mm", 0}};
  const auto target = ask(in_band);
  EXPECT_EQ(target.robot[1].by, AnsweredBy::blend);
  EXPECT_DOUBLE_EQ(target.robot[1].weight, 0.5);
  for (int i = 0; i < 3; ++i) {
    const double fine = min_angle_q(i, 325, 0, 0), coarse = min_angle_q(i, 325, 0, 0, 3);
    const auto at = static_cast<std::size_t>(3 + i);
    EXPECT_NEAR(target.q_mm[at], 0.5 * (fine + coarse), 1e-12);
    // Fine: 10 nm and 100 nm, the 70 nm of the scale within the residual, more for 325 of 300
    // arcsec; coarse: 10 nm and 10 um.
    const double beyond = (325 - 300 * 1.01) / (300 * 1.01);
    const double fine_u = std::hypot(10, 100) * (1 + beyond) * (1 + beyond);
    const double coarse_u = std::hypot(10, 1e4);
    EXPECT_NEAR(target.u_nm[at],
                std::sqrt(std::pow(0.5 * fine_u + 0.5 * coarse_u, 2) +
                          std::pow(0.25 * (fine - coarse) * 1e6, 2)),
                0.5);
  }
  EXPECT_THAT(describe_joint_flags(snapshot, target), Contains("BLENDED(ma)"));
  const auto far = ask({{"mn.x_mm", 0},
                        {"mn.y_mm", 0},
                        {"mn.z_mm", 0},
                        {"ma.rx_arcsec", 0},
                        {"ma.ry_arcsec", -900},
                        {"ma.z_mm", 0}});
  EXPECT_EQ(far.robot[1].by, AnsweredBy::coarse);
  EXPECT_NEAR(far.q_mm[3], min_angle_q(0, 0, -900, 0, 3), 1e-12);
}

TEST_F(JointTargets, TakeNamesWithoutARobotWhereOneRobotHasThem) {
  const auto named = ask({{"mn.x_mm", 1},
                          {"mn.y_mm", 2},
                          {"mn.z_mm", 0.5},
                          {"ma.rx_arcsec", 10},
                          {"ma.ry_arcsec", 20},
                          {"ma.z_mm", 0}});
  const auto short_names =
      ask({{"x_mm", 1}, {"y_mm", 2}, {"z_mm", 0.5}, {"rx_arcsec", 10}, {"ry_arcsec", 20}});
  ASSERT_EQ(short_names.refusal, Refusal::none);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(short_names.q_mm[i], named.q_mm[i]);
}

TEST_F(JointTargets, SayWhatTheRequestLacksOrHoldsTooMuch) {
  EXPECT_THAT(refusal_of({{"x_mm", 1}}),
              HasSubstr("MISSING_COORDINATE: the request lacks mn.y_mm"));
  EXPECT_THAT(refusal_of({{"x_mm", NAN}}),
              HasSubstr("NOT_FINITE: found no finite number for mn.x_mm"));
  const auto target = ask({{"x_mm", 1},
                           {"y_mm", 2},
                           {"z_mm", 0.5},
                           {"rx_arcsec", 10},
                           {"ry_arcsec", 20},
                           {"mn.rz_arcsec", 1},
                           {"ma.x_mm", 1}});
  EXPECT_THAT(describe_joint_flags(snapshot, target),
              Contains(std::string("IGNORED_COORDINATE(mn.rz_arcsec ma.x_mm)")));
  EXPECT_EQ(joint_name(snapshot, "mx.x_mm").error().reason, "UNKNOWN_NAME");
  EXPECT_THAT(joint_name(snapshot, "x_nm").error().message, HasSubstr("robots: mn, ma"));
  auto plan = joint_plan();
  plan.z_taken_by.reset();
  serve(plan, joint_models(), two_robot_cell());
  EXPECT_THAT(
      refusal_of({{"x_mm", 1}, {"y_mm", 2}, {"z_mm", 0.5}, {"rx_arcsec", 1}, {"ry_arcsec", 2}}),
      HasSubstr("AMBIGUOUS_COORDINATE: several robots"));
}

TEST_F(JointTargets, AreRefusedBeyondTheSoftLimitsOfAnyRobotAndNeverClamped) {
  const std::initializer_list<std::pair<const char*, double>> pose = {
      {"x_mm", 0}, {"y_mm", 0}, {"z_mm", 0}, {"ma.z_mm", 5.5}, {"rx_arcsec", 0}, {"ry_arcsec", 0}};
  EXPECT_THAT(refusal_of(pose), HasSubstr("OUTSIDE_LIMITS(ma.q1+ma.q2+ma.q3)"));
  auto request = request_of(pose);
  request.show_unreachable = true;
  const auto shown = compute_joint_target(snapshot, request);
  EXPECT_EQ(shown.refusal, Refusal::none);
  EXPECT_NEAR(shown.q_mm[3], 5.5, 0.02);
  EXPECT_THAT(describe_joint_flags(snapshot, shown), Contains("OUTSIDE_LIMITS(ma.q1+ma.q2+ma.q3)"));
}

TEST_F(JointTargets, NameTheRobotOfWhatIsOutsideOrOld) {
  const auto target =
      ask({{"x_mm", 3}, {"y_mm", 0}, {"z_mm", 0}, {"rx_arcsec", 0}, {"ry_arcsec", 0}});
  EXPECT_THAT(describe_joint_flags(snapshot, target), Contains("OUTSIDE_DOMAIN(mn.x_mm)"));
  auto cell = two_robot_cell();
  cell.serving.refuse_outside_domain = true;
  serve(joint_plan(), joint_models(), cell);
  EXPECT_THAT(
      refusal_of({{"x_mm", 3}, {"y_mm", 0}, {"z_mm", 0}, {"rx_arcsec", 0}, {"ry_arcsec", 0}}),
      HasSubstr("OUTSIDE_DOMAIN: mn.x_mm outside what the plan's models were fitted on"));
  // The fine model ends at 300 arcsec; in the band the coarse one vouches for the pose.
  EXPECT_EQ(
      ask({{"x_mm", 1}, {"y_mm", 0}, {"z_mm", 0}, {"rx_arcsec", 330}, {"ry_arcsec", 0}}).refusal,
      Refusal::none);
}

// Each motor by 1 um/K of t09.
void warm(calibration::Model& model, double from_degC, double to_degC) {
  for (auto& output : model.outputs) {
    const auto count = output.coefficients.size();
    output.terms.push_back(product_of({{"t09", 1}}));
    output.coefficients.conservativeResize(count + 1);
    output.coefficients[count] = 1e-3;
    output.covariance.conservativeResizeLike(Eigen::MatrixXd::Zero(count + 1, count + 1));
  }
  model.domain.push_back({{"t09", "degC"}, from_degC, to_degC});
}

TEST_F(JointTargets, NameATemperatureOutsideTheFineModelsRangeWithinTheBand) {
  auto models = joint_models();
  warm(models.at(kFine), 15, 17);  // it has 20 degC
  warm(models.at(kCoarse), 15, 22);
  const auto flags_at = [&](double rx_arcsec) {
    return describe_joint_flags(
        snapshot,
        ask({{"x_mm", 0}, {"y_mm", 0}, {"z_mm", 0}, {"rx_arcsec", rx_arcsec}, {"ry_arcsec", 0}}));
  };
  serve(joint_plan(), models, two_robot_cell());
  const std::string outside = "OUTSIDE_DOMAIN(t09_degC)";
  EXPECT_THAT(flags_at(0), Contains(outside));
  EXPECT_THAT(flags_at(325), testing::IsSupersetOf({std::string("BLENDED(ma)"), outside}));
  EXPECT_THAT(flags_at(400), Not(Contains(HasSubstr("OUTSIDE_DOMAIN"))));  // the coarse one alone
  auto cell = two_robot_cell();
  cell.serving.refuse_outside_domain = true;
  serve(joint_plan(), models, cell);
  EXPECT_THAT(
      refusal_of({{"x_mm", 0}, {"y_mm", 0}, {"z_mm", 0}, {"rx_arcsec", 325}, {"ry_arcsec", 0}}),
      HasSubstr("OUTSIDE_DOMAIN: t09_degC outside what the plan's models were fitted on"));
}

TEST_F(JointTargets, SayThatADatumLackedAChannelOfARobot) {
  const std::vector<ChannelValue> zero = {{"mn.q1_mm", 0.1}, {"mn.q2_mm", 0.1}, {"mn.q3_mm", 0.1},
                                          {"ma.q1_mm", 0.0}, {"ma.q2_mm", 0.0}, {"ma.q3_mm", 0.0},
                                          {"t09_degC", 20}};
  const auto other = [](ModelId) { return false; };
  const auto trouble = builder->anchor(zero, other);
  ASSERT_EQ(trouble.size(), 1u);
  EXPECT_THAT(trouble[0], HasSubstr("model 12: the zero of this datum has no t05_degC"));
  snapshot = builder->build(CellTime{1});
  const auto target =
      ask({{"x_mm", 1}, {"y_mm", 0}, {"z_mm", 0}, {"rx_arcsec", 0}, {"ry_arcsec", 0}});
  const auto flags = describe_joint_flags(snapshot, target);
  EXPECT_THAT(flags, Contains(std::string("UNANCHORED_DATUM(mn)")));
  EXPECT_THAT(flags, Not(Contains(std::string("UNANCHORED_DATUM(ma)"))));
}

TEST(NoPlan, IsSaid) {
  const JointSnapshot nothing;
  const auto target = compute_joint_target(nothing, {});
  EXPECT_EQ(joint_refusal_error(nothing, target).reason, "NO_PLAN");
}

}  // namespace
}  // namespace driftwise::plans
