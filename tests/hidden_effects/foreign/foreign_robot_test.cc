#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "tests/hidden_effects/foreign/generate.h"

namespace driftwise::foreign {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// The inverse polynomial and its Jacobian, worked out here from the stated coefficients.
struct Geometry {
  VectorXd s;
  MatrixXd slope;
};

Geometry geometry_at(const Robot& robot, const VectorXd& u) {
  Geometry out{robot.linear * u, robot.linear};
  for (const GeometryTerm& term : robot.higher) {
    std::vector<int> factors;
    for (int j = 0; j < robot.axes; ++j) {
      factors.insert(factors.end(), static_cast<std::size_t>(term.powers[j]), j);
    }
    double product = term.value;
    for (const int j : factors) {
      product *= u[j];
    }
    out.s[term.motor] += product;
    for (std::size_t left = 0; left < factors.size(); ++left) {
      double others = term.value;
      for (std::size_t k = 0; k < factors.size(); ++k) {
        others *= k == left ? 1.0 : u[factors[k]];
      }
      out.slope(term.motor, factors[left]) += others;
    }
  }
  return out;
}

// Normalised pose of every row of a data set without noise.
MatrixXd poses_of(const Generated& made) {
  MatrixXd u = made.true_pose * made.campaign.robot.half.cwiseInverse().asDiagonal();
  if (made.campaign.robot.zero_at_corner) {
    u.array() -= 1.0;
  }
  return u;
}

// Normalised motor values that act in a row: what the file has, less heat and force.
VectorXd acting_in(const Campaign& campaign, int row) {
  VectorXd s = campaign.s.row(row).transpose() - campaign.compliance * campaign.force_n[row];
  for (int k = 0; k < campaign.thermometer_count(); ++k) {
    s -= campaign.thermal.col(k) * (campaign.body(row, k) - campaign.body(0, k));
  }
  return s;
}

double condition(const MatrixXd& slope) {
  const VectorXd singular = Eigen::JacobiSVD<MatrixXd>(slope).singularValues();
  return singular.maxCoeff() / singular.minCoeff();
}

// Pose at a motor position on the branch of the middle: steps along a straight path, halved where
// Newton's method does not arrive.
VectorXd walked_to(const Robot& robot, const VectorXd& end) {
  VectorXd u = VectorXd::Zero(robot.axes);
  double done = 0.0;
  double step = 1.0 / 16.0;
  while (done < 1.0 && step > 1e-6) {
    const double next = std::min(done + step, 1.0);
    VectorXd found = u;
    double gap = 1.0;
    for (int k = 0; k < 5; ++k) {
      const Geometry at = geometry_at(robot, found);
      gap = (at.s - next * end).cwiseAbs().maxCoeff();
      found -= at.slope.partialPivLu().solve(at.s - next * end);
    }
    if (gap < 1e-11) {
      u = found;
      done = next;
    } else {
      step *= 0.5;
    }
  }
  return done < 1.0 ? VectorXd::Constant(robot.axes, NAN) : u;
}

void expect_far_from_singular(const Robot& robot, const VectorXd& u, const std::string& name) {
  const MatrixXd slope = geometry_at(robot, u).slope;
  EXPECT_GT(slope.determinant() / robot.linear.determinant(), 0.2) << name;
  EXPECT_LT(condition(slope), 20.0) << name;
}

// Orders of nothing hidden: open robots, and one third reserved ones.
std::vector<Order> orders() {
  std::vector<Order> made;
  for (std::uint64_t seed = 6100000; seed < 6100300; ++seed) {
    Order order;
    order.seed = seed;
    order.vary = "all";
    order.reserved = seed % 3 == 0;
    made.push_back(order);
  }
  // Robots that were singular within their stroke as they were first drawn.
  for (const std::uint64_t seed : {5800013u, 5800195u, 5801308u, 5801350u}) {
    Order order;
    order.seed = seed;
    order.reserved = true;
    made.push_back(order);
  }
  for (const std::uint64_t seed : {5600084u, 5800448u}) {
    Order order;
    order.seed = seed;
    made.push_back(order);
  }
  return made;
}

TEST(ForeignRobots, EveryRowIsARootAndEveryRobotAMachineInItsStroke) {
  std::map<std::string, int> robots;
  for (const Order& order : orders()) {
    const Generated made = generate(order);
    const Campaign& campaign = made.campaign;
    const Robot& robot = campaign.robot;
    const std::string name = robot.kind + " " + std::to_string(order.seed);
    ++robots[robot.kind];
    const MatrixXd u = poses_of(made);
    double gap = 0.0;
    for (int i = 0; i < campaign.rows(); ++i) {
      const VectorXd acting = acting_in(campaign, i);
      gap = std::max(gap,
                     (geometry_at(robot, u.row(i).transpose()).s - acting).cwiseAbs().maxCoeff());
      if (i % 20 == 0) {
        EXPECT_LT((walked_to(robot, acting) - u.row(i).transpose()).cwiseAbs().maxCoeff(), 1e-9)
            << name << ", row " << i << ": another branch than the middle's";
        expect_far_from_singular(robot, u.row(i).transpose(), name);
      }
    }
    EXPECT_LT(gap, 2e-14) << name;
    // Places that no plan chose: anywhere in the stroke, and each motor often at an end of it.
    Random random(order.seed, "places of the test");
    for (int k = 0; k < 30; ++k) {
      VectorXd s(robot.axes);
      for (int i = 0; i < robot.axes; ++i) {
        s[i] = random.chance(0.6) ? random.sign() : random.uniform(-1.0, 1.0);
      }
      const VectorXd at = walked_to(robot, s);
      ASSERT_TRUE(at.allFinite()) << name << ": the branch ends within the stroke";
      expect_far_from_singular(robot, at, name);
      EXPECT_LT((robot.pose_of(s) - at).cwiseAbs().maxCoeff(), 1e-9) << name;
    }
  }
  for (const char* kind : {"linear", "gantry", "delta", "flexure"}) {
    EXPECT_GE(robots[kind], 30) << kind;
  }
  EXPECT_GE(robots["hexapod"], 100);
}

// A robot of one axis, s = u + bend u^2. At one end of the stroke its slope is sqrt(1 - 4 |bend|).
TEST(ForeignRobots, IsNoMachineWhereItsSlopeEndsWithinTheStroke) {
  Random random(1, "robot");
  Robot robot = make_robot("linear", 2, 0.0, true, random);
  robot.linear(0, 0) = 1.0;
  for (const double bend : {-0.2, 0.05, 0.2}) {
    robot.higher = {{0, {2}, bend}};
    EXPECT_TRUE(regular_in_stroke(robot)) << bend;
  }
  // 0.24: slope 0.2. 0.3: the branch turns back before the end.
  for (const double bend : {-0.3, 0.24, 0.3}) {
    robot.higher = {{0, {2}, bend}};
    EXPECT_FALSE(regular_in_stroke(robot)) << bend;
  }
}

}  // namespace
}  // namespace driftwise::foreign
