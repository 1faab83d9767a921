// A joint target against its models asked one by one, each with terms of its own: the same digits,
// whatever of the work is shared. Random models and poses, seeded.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "server/plans/joint_target.h"
#include "tests/unit/plans/two_robots.h"

namespace driftwise::plans {
namespace {

using compensation::Snapshot;
using compensation::Target;
using compensation::TargetRequest;
using compensation::Variable;

constexpr std::size_t kAll = compensation::kVariables;

double squared(double value) { return value * value; }  // std::pow is half a digit off at times

// Slopes by the product rule, product by product.
std::vector<double> plain_slopes(const Snapshot& model, const Values& pose, std::size_t v) {
  std::vector<double> value = {1}, slope = {0};
  for (const auto& product : model.products) {
    const double column = pose[product.variable] * model.column_per_unit[product.variable] +
                          model.column_shift[product.variable];
    slope.push_back(slope[product.base] * column +
                    (product.variable == v ? value[product.base] * model.column_per_unit[v] : 0));
    value.push_back(value[product.base] * column);
  }
  // The sum of a model, by a snapshot whose products are these slopes: the same order of adding.
  std::vector<double> out;
  for (const auto& output : model.outputs) {
    std::array<double, 8> part{};
    std::size_t i = 0;
    for (; i + 8 <= slope.size(); i += 8)
      for (std::size_t k = 0; k < 8; ++k) part[k] += output.coefficients_mm[i + k] * slope[i + k];
    const double even = (part[0] + part[2]) + (part[4] + part[6]);
    const double odd = (part[1] + part[3]) + (part[5] + part[7]);
    double sum = even + odd;
    for (; i < slope.size(); ++i) sum += output.coefficients_mm[i] * slope[i];
    out.push_back(sum);
  }
  return out;
}

struct Answer {
  std::vector<double> q_mm, u_nm, terms;
};

Target ask(const Snapshot& model, const Values& pose, bool with_uncertainty) {
  TargetRequest request;
  request.value = pose;
  request.given = model.needed;
  request.with_uncertainty = with_uncertainty;
  request.show_unreachable = true;
  return compensation::compute_target(model, request);
}

// The definition in joint_target.h, with nothing shared.
Answer plain_answer(const JointSnapshot& snapshot, std::array<Values, 2> pose) {
  Answer out;
  std::array<Values, 2> variance{};
  std::vector<double> before(kMostTerms, 0.0);
  for (std::size_t pass = 0; pass < snapshot.passes; ++pass) {
    out.terms.clear();
    for (const auto& step : snapshot.steps) {
      const bool last = pass + 1 == snapshot.passes;
      const Target predicted = ask(step.predicts, pose[step.from], last);
      std::vector<double> from_before(predicted.outputs);
      for (std::size_t v = 0; last && v < kAll; ++v) {
        if (variance[step.from][v] <= 0) continue;
        const auto slope = plain_slopes(step.predicts, pose[step.from], v);
        for (std::size_t i = 0; i < predicted.outputs; ++i)
          from_before[i] += squared(slope[i]) * variance[step.from][v];
      }
      for (std::size_t i = 0; i < predicted.outputs; ++i) {
        const auto v = static_cast<std::size_t>(step.output[i]);
        const std::size_t term = out.terms.size();
        out.terms.push_back(predicted.q_mm[i]);
        if ((step.added >> i & 1) == 0) continue;
        pose[step.to][v] += predicted.q_mm[i] - before[term];
        before[term] = predicted.q_mm[i];
        if (last)
          variance[step.to][v] += squared(std::hypot(predicted.u_nm[i], std::sqrt(from_before[i])));
      }
    }
  }
  for (std::size_t r = 0; r < snapshot.robots.size(); ++r) {
    const auto& robot = snapshot.robots[r];
    const std::size_t count = robot.fine.outputs.size();
    const double w = robot.coarse ? fine_weight(robot.band, pose[r]) : 1.0;
    const double fade = robot.coarse && w < 1 ? anchor_fade(robot.band, pose[r]) : 0.0;
    const Target fine = w > 0 ? ask(robot.fine, pose[r], true) : Target{};
    const Target coarse = w < 1 ? ask(*robot.coarse, pose[r], true) : Target{};
    std::vector<double> shift(count), at_border(count);
    if (fade > 0) {
      model_coordinates(robot.fine, held_at_border(robot.band, pose[r]), shift.data());
      model_coordinates(*robot.coarse, held_at_border(robot.band, pose[r]), at_border.data());
    }
    std::vector<double> propagated(count);
    for (std::size_t v = 0; v < kAll; ++v) {
      if (variance[r][v] <= 0) continue;
      std::vector<double> slope(count), coarse_slope(count);
      if (w > 0) slope = plain_slopes(robot.fine, pose[r], v);
      if (w < 1) coarse_slope = plain_slopes(*robot.coarse, pose[r], v);
      for (std::size_t i = 0; i < count; ++i) {
        const double mixed = w * slope[i] + (1 - w) * coarse_slope[i];
        propagated[i] += mixed * mixed * variance[r][v];
      }
    }
    for (std::size_t i = 0; i < count; ++i) {
      const double moved = shift[i] - at_border[i];
      const double other = coarse.q_mm[i] + fade * moved;
      out.q_mm.push_back(w >= 1   ? fine.q_mm[i]
                         : w <= 0 ? other
                                  : w * fine.q_mm[i] + (1 - w) * other);
      const double apart_nm = w > 0 && w < 1 ? std::abs(fine.q_mm[i] - other) * kNmPerMm : 0;
      double u2 = propagated[i];
      u2 += squared((w > 0 ? w * fine.u_nm[i] : 0) + (w < 1 ? (1 - w) * coarse.u_nm[i] : 0));
      u2 += squared(w * (1 - w) * apart_nm);
      u2 += squared((1 - w) * fade * (1 - fade) * moved * kNmPerMm);
      out.u_nm.push_back(std::sqrt(u2));
    }
  }
  return out;
}

class RandomPlans {
 public:
  explicit RandomPlans(std::uint64_t seed) : random_(seed) {}

  // Products of up to `order` of the model's own inputs, besides the terms it has.
  void widen(calibration::Model& model, int order, double size) {
    std::vector<std::string> inputs;
    for (const auto& range : model.domain)
      if (range.channel.symbol.find('.') != std::string::npos)
        inputs.push_back(range.channel.symbol);
    for (auto& output : model.outputs) {
      for (const auto& symbol : inputs)
        for (const auto& other : inputs)
          output.terms.push_back(product_of({{symbol, order}, {other, 1}}));
      const auto count = static_cast<Eigen::Index>(output.terms.size());
      const auto known = output.coefficients.size();
      output.coefficients.conservativeResize(count);
      for (Eigen::Index k = known; k < count; ++k) output.coefficients[k] = size * normal_(random_);
      const Eigen::MatrixXd root =
          Eigen::MatrixXd::NullaryExpr(count, count, [&] { return size * normal_(random_); });
      output.covariance = root * root.transpose();
    }
  }
  double between(double from, double to) {
    return std::uniform_real_distribution<double>(from, to)(random_);
  }

 private:
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
};

class JointReference : public testing::TestWithParam<bool> {
};  // fine and coarse with the same terms

TEST_P(JointReference, GivesTheDigitsOfItsModelsAskedOneByOne) {
  RandomPlans random(GetParam() ? 1 : 2);
  auto plan = joint_plan();
  plan.robots[1].blend->anchored = true;
  for (auto& edge : plan.robots[1].blend->band) edge.fade_to = 1500;
  auto models = joint_models();
  follow_the_tilt(models.at(kMinAngleMotion), 1e-4);  // several passes
  random.widen(models.at(kMicroNano), 2, 1e-6);
  random.widen(models.at(kFine), 2, 1e-13);
  random.widen(models.at(kCoarse), GetParam() ? 2 : 1, 1e-13);
  random.widen(models.at(kMicroNanoTilt), 2, 1e-4);
  auto builder = std::move(*JointBuilder::create(plan, PlanId{1}, models, two_robot_cell()));
  builder.anchor({}, [](ModelId) { return true; });
  const ChannelValue values[] = {{"t05_degC", 20.5}, {"t09_degC", 20.0}};
  builder.observe(values, CellTime{1});
  const auto snapshot = builder.build(CellTime{1});
  EXPECT_EQ(snapshot.robots[1].same_terms, GetParam());
  EXPECT_GT(snapshot.passes, 1u);
  std::array<int, 4> answered{};
  for (int i = 0; i < 3000; ++i) {
    std::array<Values, 2> pose{};
    JointRequest request;
    const double reach = i % 3 == 0 ? 280 : i % 3 == 1 ? 400 : 1700;
    const auto state = [&](std::size_t robot, Variable v, double value) {
      request.set(robot, v, value);
      pose[robot][static_cast<std::size_t>(v)] = value;
    };
    for (const auto v : {Variable::x, Variable::y, Variable::z}) state(0, v, random.between(-2, 2));
    for (const auto v : {Variable::rx, Variable::ry}) state(1, v, random.between(-reach, reach));
    state(1, Variable::z, random.between(-3, 3));
    const auto target = compute_joint_target(snapshot, request);
    ASSERT_EQ(target.refusal, compensation::Refusal::none);
    ++answered[static_cast<std::size_t>(target.robot[1].by)];
    const auto plain = plain_answer(snapshot, pose);
    ASSERT_EQ(target.terms, plain.terms.size());
    for (std::size_t k = 0; k < target.terms; ++k)
      ASSERT_EQ(target.term[k].value, plain.terms[k]) << k;
    ASSERT_EQ(target.outputs, plain.q_mm.size());
    for (std::size_t k = 0; k < target.outputs; ++k) {
      ASSERT_EQ(target.q_mm[k], plain.q_mm[k]) << k;
      ASSERT_EQ(target.u_nm[k], plain.u_nm[k]) << k;
    }
  }
  for (const auto by : {AnsweredBy::fine, AnsweredBy::coarse, AnsweredBy::blend})
    EXPECT_GT(answered[static_cast<std::size_t>(by)], 100);
}
INSTANTIATE_TEST_SUITE_P(Terms, JointReference, testing::Bool(), [](const auto& row) {
  return std::string(row.param ? "TheSame" : "OfTheirOwn");
});

}  // namespace
}  // namespace driftwise::plans
