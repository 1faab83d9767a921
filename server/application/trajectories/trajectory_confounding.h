#pragma once
// What no fit could tell apart afterwards, seen in the plan before anything is measured. Pure.
//
// Force and time: while the room warms, whatever grows with time grows with the temperatures, and a
// force that rises along with them shares its effect with theirs. The correlation r of force and
// time over the calibration rows says how much: the standard error of the force's coefficient is
// 1 / sqrt(1 - r^2) times that of a plan without the trend (variance inflation; Draper and Smith,
// Applied Regression Analysis, 3rd ed., section 16.4).
//
// Terms of position: on a grid with few levels, or along one diagonal, powers of the coordinates
// are combinations of one another.

#include <span>
#include <string>
#include <vector>

#include "server/core/trajectory/trajectory.h"

namespace driftwise::application {

inline constexpr double kConfounded = 0.8;  // |r|: the standard error grows by 1.7

// Pearson's; 0 when one of them does not vary.
double correlation(std::span<const double> a, std::span<const double> b);

struct ForceTrend {
  std::size_t rows = 0;          // calibration rows with a force
  double correlation = 0;        // with time, over them
  std::vector<double> order_n;   // the forces, in the order in which they come
  std::vector<double> better_n;  // the same forces in the order that follows time least
  double better_correlation = 0;
  bool confounded() const;
  std::string sentence() const;
};

// time_s: when each row is expected to be measured, increasing. Blocks are stretches of rows of one
// force; better_n is searched over all orders of up to 7 calibration blocks, else it is empty.
ForceTrend force_trend(const Trajectory& trajectory, std::span<const double> time_s);

// "q1^2 cannot be told apart from q1 on the calibration rows (q1 takes 2 values)": every monomial
// of total degree 1 .. 3 that equals a combination of those before it, to 1e-6 of its size. Nothing
// is said of plans with fewer calibration rows than twice the monomials: they are no plan for a
// fit.
std::vector<std::string> look_alikes(const Trajectory& trajectory);

}  // namespace driftwise::application
