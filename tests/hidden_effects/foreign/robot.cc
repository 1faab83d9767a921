#include "tests/hidden_effects/foreign/robot.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "tests/hidden_effects/foreign/monomials.h"

namespace driftwise::foreign {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

std::vector<std::string> pose_names(const std::string& kind, int axes, Random& random) {
  if (kind == "linear") {
    return {"x"};
  }
  switch (axes) {
    case 1:
      return {random.pick(std::vector<std::string>{"x", "z", "rz"})};
    case 2:
      return {"x", random.chance(0.5) ? "y" : "z"};
    case 3:
      if (kind == "flexure" && random.chance(0.4)) {
        return {"z", "rx", "ry"};
      }
      return {"x", "y", "z"};
    case 4:
      return {"x", "y", "z", "rz"};
    case 5:
      return {"x", "y", "z", "rx", "ry"};
    default:
      return {"x", "y", "z", "rx", "ry", "rz"};
  }
}

int drawn_axes(const std::string& kind, Random& random) {
  if (kind == "linear") {
    return 1;
  }
  if (kind == "delta") {
    return 3;
  }
  if (kind == "hexapod") {
    return 6;
  }
  if (kind == "flexure") {
    return random.pick(std::vector<int>{1, 2, 3, 3, 3});
  }
  return random.pick(std::vector<int>{1, 2, 2, 3, 3, 3, 4, 5, 6});
}

void draw_strokes(Robot& robot, bool reference, Random& random) {
  // Half strokes: 100 um to 10 m of stroke over all kinds; a flexure bends little, a gantry is
  // large.
  double half_mm = 0.0;
  if (reference) {
    half_mm = robot.kind == "linear" ? 4.0 : 1.25;
  } else if (robot.kind == "flexure") {
    half_mm = random.log_uniform(0.05, 5.0);
  } else if (robot.kind == "delta" || robot.kind == "hexapod") {
    half_mm = random.log_uniform(0.5, 200.0);
  } else {
    half_mm = random.log_uniform(0.05, 5000.0);
  }
  const double noise_scale = reference ? 1.0 : random.log_uniform(0.6, 1.7);
  for (int j = 0; j < robot.axes; ++j) {
    const bool angle = robot.pose_is_angle[j];
    robot.half[j] = angle ? (reference ? 300.0 : random.log_uniform(50.0, 4.0e4))
                          : half_mm * (reference ? 1.0 : random.uniform(0.5, 1.0));
    // 5 nm at 10 mm, 1 nm at 0.1 mm, 60 nm at 10 m; angles 0.02 arcsec at 300 arcsec.
    robot.sigma[j] = angle ? 0.02 * std::pow(robot.half[j] / 300.0, 0.5) * noise_scale
                           : 5e-6 * std::pow(robot.half[j] / 5.0, 0.36) * noise_scale;
  }
}

constexpr double kNarrower = 1.25;
constexpr int kPathSteps = 8;
// Gap of a root in normalised motor units: rounding is below 1e-14.
constexpr double kRoot = 1e-12;

// Ends of the paths: all of {-1, 0, 1}^axes up to three axes, else the corners.
std::vector<VectorXd> ends_of_stroke(int axes) {
  const int levels = axes <= 3 ? 3 : 2;
  const int count = static_cast<int>(std::lround(std::pow(levels, axes)));
  std::vector<VectorXd> ends;
  for (int k = 0; k < count; ++k) {
    VectorXd s(axes);
    int rest = k;
    for (int i = 0; i < axes; ++i) {
      s[i] = 2.0 * (rest % levels) / (levels - 1) - 1.0;
      rest /= levels;
    }
    if (s.cwiseAbs().maxCoeff() > 0.0) {
      ends.push_back(s);
    }
  }
  return ends;
}

// Newton's method from a pose nearby. False where it does not arrive.
bool follow(const Robot& robot, const VectorXd& s, VectorXd& u) {
  for (int step = 0; step < 12; ++step) {
    const VectorXd gap = s - robot.motor_of(u);
    if (gap.cwiseAbs().maxCoeff() < kRoot) {
      return true;
    }
    u += robot.jacobian(u).partialPivLu().solve(gap);
    if (!u.allFinite()) {
      return false;
    }
  }
  return false;
}

bool regular_on_path(const Robot& robot, const VectorXd& end, double middle) {
  VectorXd u = VectorXd::Zero(robot.axes);
  for (int step = 1; step <= kPathSteps; ++step) {
    if (!follow(robot, end * (static_cast<double>(step) / kPathSteps), u)) {
      return false;
    }
    const MatrixXd slope = robot.jacobian(u);
    if (slope.determinant() / middle < kNarrower * kLeastDeterminantShare) {
      return false;
    }
    const VectorXd singular = Eigen::JacobiSVD<MatrixXd>(slope).singularValues();
    if (singular.maxCoeff() * kNarrower > singular.minCoeff() * kLargestCondition) {
      return false;
    }
  }
  return (robot.pose_of(end) - u).cwiseAbs().maxCoeff() < 1e-9;
}

}  // namespace

bool regular_in_stroke(const Robot& robot) {
  const double middle = robot.linear.determinant();
  const std::vector<VectorXd> ends = ends_of_stroke(robot.axes);
  return std::all_of(ends.begin(), ends.end(),
                     [&](const VectorXd& end) { return regular_on_path(robot, end, middle); });
}

const std::vector<std::string>& open_robots() {
  static const std::vector<std::string> kinds{"linear", "gantry", "delta", "flexure"};
  return kinds;
}

const std::vector<std::string>& reserved_robots() {
  static const std::vector<std::string> kinds{"hexapod"};
  return kinds;
}

Robot make_robot(const std::string& kind, int degree, double askew_rad, bool reference,
                 Random& random) {
  Robot robot;
  robot.kind = kind;
  robot.axes = reference ? (kind == "linear" ? 1 : 3) : drawn_axes(kind, random);
  robot.pose = reference && kind != "linear" ? std::vector<std::string>{"x", "y", "z"}
                                             : pose_names(kind, robot.axes, random);
  const bool parallel = kind == "delta" || kind == "flexure" || kind == "hexapod";
  for (const std::string& name : robot.pose) {
    robot.pose_is_angle.push_back(name[0] == 'r');
    robot.motor_is_angle.push_back(name[0] == 'r' && !parallel);
  }
  robot.half.resize(robot.axes);
  robot.motor_half.resize(robot.axes);
  robot.sigma.resize(robot.axes);
  draw_strokes(robot, reference, random);
  double length_half = 5.0;
  for (int j = 0; j < robot.axes; ++j) {
    if (!robot.pose_is_angle[j]) {
      length_half = robot.half[j];
    }
  }
  for (int i = 0; i < robot.axes; ++i) {
    robot.motor_half[i] = parallel ? length_half : robot.half[i];
  }
  robot.zero_at_corner = reference ? kind != "linear" : random.chance(0.4);
  robot.degree = robot.axes >= 4 ? std::min(degree, 2) : degree;

  // Linear part: a gantry is nearly the identity, a parallel robot mixes its axes.
  MatrixXd linear = MatrixXd::Identity(robot.axes, robot.axes);
  const double mixing = kind == "delta" || kind == "hexapod" ? 0.35
                        : kind == "flexure"                  ? 0.02
                                                             : 0.0;
  for (int i = 0; i < robot.axes; ++i) {
    for (int j = 0; j < robot.axes; ++j) {
      if (i != j) {
        linear(i, j) += mixing * random.uniform(-1.0, 1.0) +
                        (i < j ? askew_rad : -askew_rad) * random.uniform(0.5, 1.0);
      } else {
        linear(i, j) += 2e-5 * random.normal();
      }
    }
  }
  robot.linear = linear;
  const double bend = kind == "delta" || kind == "hexapod" ? random.log_uniform(5e-3, 3e-2)
                      : kind == "flexure"                  ? random.log_uniform(1e-4, 3e-3)
                                                           : random.log_uniform(1e-6, 1e-4);
  for (const std::vector<int>& powers : monomials(robot.axes, robot.degree)) {
    int total = 0;
    for (const int power : powers) {
      total += power;
    }
    if (total < 2) {
      continue;
    }
    for (int i = 0; i < robot.axes; ++i) {
      robot.higher.push_back({i, powers, bend * random.normal() / std::pow(2.0, total - 2)});
    }
  }
  return robot;
}

VectorXd Robot::motor_of(const VectorXd& u) const {
  VectorXd s = linear * u;
  for (const GeometryTerm& term : higher) {
    s[term.motor] += term.value * monomial_value(term.powers, u);
  }
  return s;
}

MatrixXd Robot::jacobian(const VectorXd& u) const {
  MatrixXd slope = linear;
  for (const GeometryTerm& term : higher) {
    for (int j = 0; j < axes; ++j) {
      if (term.powers[j] > 0) {
        std::vector<int> lower = term.powers;
        --lower[j];
        slope(term.motor, j) += term.value * term.powers[j] * monomial_value(lower, u);
      }
    }
  }
  return slope;
}

VectorXd Robot::pose_of(const VectorXd& s) const {
  VectorXd u = linear.partialPivLu().solve(s);
  for (int step = 0; step < 30; ++step) {
    const VectorXd gap = s - motor_of(u);
    u += jacobian(u).partialPivLu().solve(gap);
    if (gap.cwiseAbs().maxCoeff() < 1e-15) {
      break;
    }
  }
  return u;
}

double Robot::pose_value(int coordinate, double u) const {
  return half[coordinate] * (u + (zero_at_corner ? 1.0 : 0.0));
}

VectorXd Robot::normalised(const VectorXd& values) const {
  VectorXd u = values.cwiseQuotient(half);
  if (zero_at_corner) {
    u.array() -= 1.0;
  }
  return u;
}

double Robot::motor_value(int motor, double s) const {
  return motor_half[motor] * (s + (zero_at_corner ? 1.0 : 0.0));
}

}  // namespace driftwise::foreign
