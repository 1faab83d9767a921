#include <fmt/format.h>

#include <Eigen/Dense>
#include <cmath>
#include <set>

#include "server/application/trajectories/trajectory_confounding.h"

namespace driftwise::application {
namespace {

constexpr int kDegree = 3;
constexpr double kNothingLeft = 1e-6;

using Powers = std::vector<int>;  // one exponent per coordinate

void add_powers(std::size_t coordinate, int degree_left, Powers& powers, std::vector<Powers>& out) {
  if (coordinate + 1 == powers.size()) {
    powers[coordinate] = degree_left;
    out.push_back(powers);
    return;
  }
  for (int power = degree_left; power >= 0; --power) {
    powers[coordinate] = power;
    add_powers(coordinate + 1, degree_left - power, powers, out);
  }
}

// Of total degree 1 .. kDegree, low degrees first: what a term equals is named in simpler ones.
std::vector<Powers> monomials_of(std::size_t coordinates) {
  std::vector<Powers> all;
  for (int degree = 1; degree <= kDegree; ++degree) {
    Powers powers(coordinates, 0);
    add_powers(0, degree, powers, all);
  }
  return all;
}

std::string name_of(const Powers& powers, const std::vector<Channel>& coordinates) {
  std::string name;
  for (std::size_t i = 0; i < powers.size(); ++i) {
    if (powers[i] == 0) continue;
    name += (name.empty() ? "" : ":") + coordinates[i].symbol;
    if (powers[i] > 1) name += fmt::format("^{}", powers[i]);
  }
  return name;
}

// Each coordinate over its largest size, so that every power stays within 1.
Eigen::MatrixXd scaled_rows(const Trajectory& trajectory) {
  std::vector<const TrajectoryPoint*> rows;
  for (const auto& point : trajectory.points)
    if (point.set == PointSet::calibration) rows.push_back(&point);
  const auto columns = static_cast<Eigen::Index>(trajectory.coordinates.size());
  Eigen::MatrixXd x(static_cast<Eigen::Index>(rows.size()), columns);
  for (Eigen::Index i = 0; i < x.rows(); ++i)
    for (Eigen::Index j = 0; j < columns; ++j)
      x(i, j) = rows[static_cast<std::size_t>(i)]->target[static_cast<std::size_t>(j)];
  for (Eigen::Index j = 0; j < columns && x.rows() > 0; ++j)
    if (const double largest = x.col(j).cwiseAbs().maxCoeff(); largest > 0) x.col(j) /= largest;
  return x;
}

std::string levels_sentence(const Powers& powers, const std::vector<Channel>& coordinates,
                            const Eigen::MatrixXd& x) {
  std::string levels;
  for (std::size_t j = 0; j < powers.size(); ++j) {
    if (powers[j] == 0) continue;
    const auto column = x.col(static_cast<Eigen::Index>(j));
    const std::set<double> values(column.begin(), column.end());
    levels += fmt::format("{}{} takes {} value{}", levels.empty() ? "" : ", ",
                          coordinates[j].symbol, values.size(), values.size() == 1 ? "" : "s");
  }
  return levels;
}

}  // namespace

std::vector<std::string> look_alikes(const Trajectory& trajectory) {
  const auto x = scaled_rows(trajectory);
  const auto monomials = monomials_of(trajectory.coordinates.size());
  if (x.rows() < 2 * static_cast<Eigen::Index>(monomials.size())) return {};
  std::vector<std::string> sentences;
  std::vector<const Powers*> kept;
  Eigen::MatrixXd basis = Eigen::MatrixXd::Ones(x.rows(), 1);  // the constant is always there
  for (const auto& powers : monomials) {
    Eigen::VectorXd column = Eigen::VectorXd::Ones(x.rows());
    for (std::size_t j = 0; j < powers.size(); ++j)
      for (int k = 0; k < powers[j]; ++k)
        column.array() *= x.col(static_cast<Eigen::Index>(j)).array();
    const Eigen::VectorXd weights = basis.colPivHouseholderQr().solve(column);
    if ((column - basis * weights).norm() > kNothingLeft * column.norm()) {
      kept.push_back(&powers);
      basis.conservativeResize(Eigen::NoChange, basis.cols() + 1);
      basis.col(basis.cols() - 1) = column;
      continue;
    }
    std::string others;
    for (std::size_t i = 0; i < kept.size(); ++i)
      if (std::abs(weights[static_cast<Eigen::Index>(i) + 1]) > kNothingLeft)
        others += (others.empty() ? "" : ", ") + name_of(*kept[i], trajectory.coordinates);
    const auto name = name_of(powers, trajectory.coordinates);
    const auto levels = levels_sentence(powers, trajectory.coordinates, x);
    sentences.push_back(
        others.empty() ? fmt::format("{} is constant on the calibration rows ({})", name, levels)
                       : fmt::format("{} cannot be told apart from {} on the calibration rows ({})",
                                     name, others, levels));
  }
  return sentences;
}

}  // namespace driftwise::application
