#include "server/identification/identifiability.h"

#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <random>

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

// Postures that nobody planned, inputs x postures: angles all round, all else about the middle of
// the rows by the most that an input of its unit went.
Eigen::MatrixXd generic_postures(const std::vector<Channel>& channels,
                                 const Eigen::MatrixXd& inputs, Index count) {
  const double infinity = std::numeric_limits<double>::infinity();
  Eigen::VectorXd low = Eigen::VectorXd::Constant(inputs.rows(), infinity), high = -low;
  for (Index row = 0; row < inputs.cols(); ++row) {
    if (!inputs.col(row).allFinite()) continue;
    low = low.cwiseMin(inputs.col(row));
    high = high.cwiseMax(inputs.col(row));
  }
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  Eigen::MatrixXd postures(inputs.rows(), count);
  for (Index i = 0; i < inputs.rows(); ++i) {
    const std::string& unit = channels[static_cast<std::size_t>(i)].unit;
    double middle = 0, half = unit == "deg" ? 180 : std::numbers::pi;
    if (unit != "deg" && unit != "rad") {
      middle = (low[i] + high[i]) / 2;
      half = 0;
      for (Index k = 0; k < inputs.rows(); ++k)
        if (channels[static_cast<std::size_t>(k)].unit == unit)
          half = std::max(half, (high[k] - low[k]) / 2);
    }
    for (Index row = 0; row < count; ++row) postures(i, row) = middle + half * uniform(random);
  }
  return postures;
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

std::vector<std::string> hidden_in_every_posture(const kinematics::Mechanism& mechanism,
                                                 const Eigen::VectorXd& values,
                                                 const Eigen::MatrixXd& inputs) {
  const auto& parameters = mechanism.parameters();
  const auto count = static_cast<Index>(parameters.size());
  const Index outputs = static_cast<Index>(mechanism.outputs().size());
  const Eigen::MatrixXd postures = generic_postures(mechanism.inputs(), inputs, 4 * count);
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(postures.cols() * outputs, count);
  for (Index row = 0; row < postures.cols(); ++row) {
    const auto at =
        mechanism.predict({postures.col(row).data(), static_cast<std::size_t>(postures.rows())},
                          values, kinematics::Derivatives::yes);
    if (at.value.allFinite() && at.jacobian.allFinite())
      jacobian.middleRows(row * outputs, outputs) = at.jacobian;
  }
  for (Index k = 0; k < count; ++k)
    jacobian.col(k) *= parameters[static_cast<std::size_t>(k)].natural;
  const auto found = identifiable(jacobian, parameters);
  std::vector<std::string> names;
  for (std::size_t k = 0; k < parameters.size(); ++k)
    if (found.free[k] == 0 && !parameters[k].held && !parameters[k].placement)
      names.push_back(parameters[k].name);
  return names;
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
