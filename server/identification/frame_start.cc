#include "server/identification/frame_start.h"

#include <cmath>
#include <vector>

#include "server/core/try.h"
#include "server/identification/least_squares.h"
#include "server/kinematics/frame.h"
#include "server/kinematics/rigid_fit.h"

namespace driftwise::identification {
namespace {

using Eigen::Index;
using kinematics::kFrameParameters;

// The free ones of the six, in natural units from where they begin.
struct FrameWork {
  Eigen::Matrix3Xd points, measured;
  const kinematics::Parameters& parameters;
  std::vector<Index> free;
  Eigen::VectorXd begin;

  Eigen::VectorXd values(const Eigen::VectorXd& unknown) const {
    Eigen::VectorXd all = begin;
    for (std::size_t k = 0; k < free.size(); ++k)
      all[free[k]] += unknown[static_cast<Index>(k)] * natural(k);
    return all;
  }
  double natural(std::size_t k) const {
    return parameters[static_cast<std::size_t>(free[k])].natural;
  }
  Eigen::VectorXd residuals(const Eigen::VectorXd& unknown) const {
    const kinematics::Frame frame(values(unknown));
    Eigen::Matrix3Xd left(3, points.cols());
    for (Index i = 0; i < points.cols(); ++i)
      left.col(i) = frame.outer(points.col(i)) - measured.col(i);
    return left.reshaped();
  }
  Eigen::MatrixXd jacobian(const Eigen::VectorXd& unknown) const {
    const kinematics::Frame frame(values(unknown));
    Eigen::MatrixXd all(3 * points.cols(), static_cast<Index>(free.size()));
    for (Index i = 0; i < points.cols(); ++i) {
      const auto derivatives = frame.outer_derivatives(points.col(i));
      for (std::size_t k = 0; k < free.size(); ++k)
        all.block<3, 1>(3 * i, static_cast<Index>(k)) = derivatives.col(free[k]) * natural(k);
    }
    return all;
  }
  // The free translations that suit the rotations it begins with.
  void centre() {
    const kinematics::Frame frame(begin);
    const Eigen::Vector3d mean = measured.rowwise().mean();
    const Eigen::Vector3d off = mean - frame.outer(points.rowwise().mean());
    for (const Index one : free)
      if (one < 3) begin[one] += off[one];
  }
};

// The nearest minimum from where it begins; false: none was found.
bool settle(FrameWork& work, double& sum_of_squares) {
  const LeastSquaresProblem problem{
      [&work](const Eigen::VectorXd& unknown) { return work.residuals(unknown); },
      [&work](const Eigen::VectorXd& unknown) { return work.jacobian(unknown); }};
  const auto solution =
      minimise(problem, Eigen::VectorXd::Zero(static_cast<Index>(work.free.size())));
  if (!solution) return false;
  work.begin = work.values(solution->values);
  sum_of_squares = solution->sum_of_squares;
  return true;
}

// At most kSearched points from all over: enough to tell one turn from another.
Eigen::Matrix3Xd some_of(const Eigen::Matrix3Xd& points) {
  constexpr Index kSearched = 30;
  if (points.cols() <= kSearched) return points;
  Eigen::Matrix3Xd some(3, kSearched);
  for (Index i = 0; i < kSearched; ++i) some.col(i) = points.col(points.cols() * i / kSearched);
  return some;
}

double within_half_turn(double deg) { return std::remainder(deg, 360.0); }

}  // namespace

Result<Eigen::VectorXd> frame_start(const Eigen::Matrix3Xd& points,
                                    const Eigen::Matrix3Xd& measured,
                                    const kinematics::Parameters& parameters) {
  const Eigen::VectorXd nominal = kinematics::nominal_values(parameters).head<kFrameParameters>();
  FrameWork work{some_of(points), some_of(measured), parameters, {}, nominal};
  for (Index i = 0; i < kFrameParameters; ++i)
    if (!parameters[static_cast<std::size_t>(i)].held) work.free.push_back(i);
  if (work.free.empty()) return nominal;
  DRIFTWISE_TRY(const auto rigid, kinematics::fit_rigid(points, measured));
  const Eigen::VectorXd whole = kinematics::frame_values(rigid.rotation, rigid.translation);
  if (work.free.size() == kFrameParameters) return whole;

  // A held rotation leaves the others several minima: each free one begins in every quarter turn.
  Eigen::VectorXd best = nominal;
  double least = HUGE_VAL;
  for (int quarters = 0; quarters < 64; ++quarters) {
    const int turns[] = {quarters % 4, quarters / 4 % 4, quarters / 16};
    work.begin = nominal;
    bool again = false;
    for (Index i = 0; i < 3; ++i) {
      if (!parameters[static_cast<std::size_t>(3 + i)].held)
        work.begin[3 + i] = whole[3 + i] + 90 * turns[i];
      else
        again = again || turns[i] != 0;  // this start was there already
    }
    if (again) continue;
    work.centre();
    double squares = 0;
    if (!settle(work, squares) || !(squares < 0.999999 * least)) continue;
    least = squares;
    best = work.begin;
  }
  work.points = points;
  work.measured = measured;
  work.begin = best;
  double squares = 0;
  if (settle(work, squares)) best = work.begin;
  for (const Index one : work.free)
    if (one >= 3) best[one] = within_half_turn(best[one]);
  return best;
}

}  // namespace driftwise::identification
