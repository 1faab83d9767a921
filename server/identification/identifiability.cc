#include "server/identification/identifiability.h"

#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace driftwise::identification {
namespace {

using Eigen::Index;

// The derivatives are exact to about 1e-13; what is below is rounding, or a second-order effect of
// a deviation that the data may contain but that no honest interval can be given for.
constexpr double kApart = 1e-7;
constexpr double kNoEffect = 1e-10;  // of the largest effect of any parameter's natural deviation
constexpr double kMentioned = 0.05;  // of the largest share in a combination
constexpr std::size_t kMostMentioned = 4;

std::string note_of(const Eigen::VectorXd& shares, const std::vector<Index>& kept,
                    const kinematics::Parameters& parameters) {
  std::vector<Index> order(kept.size());
  std::iota(order.begin(), order.end(), Index{0});
  std::ranges::sort(order, std::ranges::greater{},
                    [&shares](Index i) { return std::abs(shares[i]); });
  std::string text;
  std::size_t count = 0;
  for (const Index i : order) {
    if (std::abs(shares[i]) < kMentioned * std::abs(shares[order.front()])) break;
    if (++count > kMostMentioned) {
      text += ", ...";
      break;
    }
    text += (text.empty() ? "" : ", ") +
            parameters[static_cast<std::size_t>(kept[static_cast<std::size_t>(i)])].name;
  }
  return "cannot be told apart from " + text;
}

}  // namespace

Identifiability identifiable(const Eigen::MatrixXd& jacobian,
                             const kinematics::Parameters& parameters) {
  const auto count = parameters.size();
  Identifiability result{std::vector<char>(count, 0), std::vector<std::string>(count), 1};
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return parameters[i].rank; });

  Eigen::MatrixXd basis(jacobian.rows(), static_cast<Index>(count));    // orthonormal
  Eigen::MatrixXd columns(jacobian.rows(), static_cast<Index>(count));  // kept, unit length
  std::vector<Index> kept;
  const double largest = jacobian.size() > 0 ? jacobian.colwise().norm().maxCoeff() : 0;
  for (const std::size_t i : order) {
    if (parameters[i].held) {
      result.notes[i] = "held by the robot file";
      continue;
    }
    const auto rank = static_cast<Index>(kept.size());
    Eigen::VectorXd column = jacobian.col(static_cast<Index>(i));
    const double length = column.norm();
    if (!(length > kNoEffect * largest)) {
      result.notes[i] = "has no effect on these rows";
      continue;
    }
    column /= length;
    Eigen::VectorXd left = column;
    for (int pass = 0; pass < 2; ++pass)  // twice is enough (Giraud, Langou 2002)
      left -= basis.leftCols(rank) * (basis.leftCols(rank).transpose() * left);
    if (left.norm() < kApart) {
      const Eigen::VectorXd shares = columns.leftCols(rank).householderQr().solve(column);
      result.notes[i] = note_of(shares, kept, parameters);
      continue;
    }
    basis.col(rank) = left.normalized();
    columns.col(rank) = column;
    kept.push_back(static_cast<Index>(i));
    result.free[i] = 1;
  }
  if (kept.empty()) return result;
  const Eigen::MatrixXd chosen = columns.leftCols(static_cast<Index>(kept.size()));
  const Eigen::MatrixXd triangle = chosen.householderQr().matrixQR().topRows(chosen.cols());
  const Eigen::VectorXd singular =
      Eigen::JacobiSVD<Eigen::MatrixXd>(Eigen::MatrixXd(triangle.triangularView<Eigen::Upper>()))
          .singularValues();
  result.condition = singular[0] / singular[singular.size() - 1];
  return result;
}

Eigen::MatrixXd inverse_normal(const Eigen::MatrixXd& jacobian) {
  if (jacobian.cols() == 0) return {};
  const Eigen::VectorXd lengths = jacobian.colwise().norm();
  const Eigen::MatrixXd scaled = jacobian * lengths.cwiseInverse().asDiagonal();
  const Eigen::MatrixXd triangle = scaled.householderQr().matrixQR().topRows(scaled.cols());
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(
      Eigen::MatrixXd(triangle.triangularView<Eigen::Upper>()), Eigen::ComputeFullV);
  const Eigen::MatrixXd root = lengths.cwiseInverse().asDiagonal() * svd.matrixV() *
                               svd.singularValues().cwiseInverse().asDiagonal();
  return root * root.transpose();
}

}  // namespace driftwise::identification
