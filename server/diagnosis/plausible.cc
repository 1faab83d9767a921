#include "server/diagnosis/plausible.h"

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "server/core/units.h"
#include "server/effects/term_order.h"

namespace driftwise::diagnosis {
namespace {

constexpr double kLargestExpansion_ppm_per_k = 30;  // NUMERICS.md section 3
constexpr double kShareBeyondGeometry = 0.5;
constexpr int kDegreeOfOneAxis = 6;  // of two axes 5, of three 4
constexpr Eigen::Index kFewestRowsPerMonomial = 5;
constexpr double kUnlimited = std::numeric_limits<double>::infinity();
constexpr std::array<const char*, 3> kAxes = {"x", "y", "z"}, kTilts = {"rx", "ry", "rz"};

// Of the three names, the one that the term reads; -1: none.
int read_by(const effects::Term& term, const std::array<const char*, 3>& names) {
  for (const auto& symbol : effects::symbols_of(term))
    for (std::size_t i = 0; i < names.size(); ++i)
      if (symbol == names[i]) return static_cast<int>(i);
  return -1;
}

// Output over x, y, z by least squares: enough to turn a limit along one into one of the other.
Eigen::MatrixXd slopes_of(const Problem& problem) {
  const auto rows = static_cast<Eigen::Index>(problem.learn.size());
  std::vector<Eigen::Index> axes;
  Eigen::MatrixXd pose = Eigen::MatrixXd::Ones(rows, 4);
  Eigen::Index count = 1;
  for (std::size_t axis = 0; axis < kAxes.size(); ++axis) {
    const auto values = problem.data().values_of(kAxes[axis]);
    if (values.empty()) continue;
    for (Eigen::Index i = 0; i < rows; ++i)
      pose(i, count) = values[problem.learn[static_cast<std::size_t>(i)]];
    const double first = pose(0, count);
    if ((pose.col(count).array() == first).all()) continue;
    axes.push_back(static_cast<Eigen::Index>(axis));
    ++count;
  }
  const auto outputs = static_cast<Eigen::Index>(problem.outputs.size());
  Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(outputs, 3);
  if (rows <= count) return slopes;
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(pose.leftCols(count));
  for (Eigen::Index o = 0; o < outputs; ++o) {
    Eigen::VectorXd measured(rows);
    for (Eigen::Index i = 0; i < rows; ++i)
      measured[i] =
          problem.outputs[static_cast<std::size_t>(o)]
              .measured[static_cast<Eigen::Index>(problem.learn[static_cast<std::size_t>(i)])];
    const Eigen::VectorXd b = qr.solve(measured);
    for (std::size_t k = 0; k < axes.size(); ++k)
      slopes(o, axes[k]) = b[static_cast<Eigen::Index>(k) + 1];
  }
  return slopes;
}

// All monomials of the axes that vary up to a total degree, each axis scaled to -1 .. 1: one row
// per block.
Eigen::MatrixXd geometry_of(const Problem& problem) {
  const auto rows = static_cast<Eigen::Index>(problem.data().rows);
  std::vector<Eigen::ArrayXd> axes;
  for (const char* axis : kAxes) {
    const auto values = problem.data().values_of(axis);
    if (values.empty()) continue;
    double low = kUnlimited, high = -kUnlimited;
    for (const std::size_t row : problem.learn) {
      low = std::min(low, values[row]);
      high = std::max(high, values[row]);
    }
    if (!(high > low)) continue;
    axes.push_back((Eigen::Map<const Eigen::ArrayXd>(values.data(), rows) - (low + high) / 2) /
                   ((high - low) / 2));
  }
  const int degree = kDegreeOfOneAxis - static_cast<int>(axes.size()) + 1;
  std::vector<Eigen::ArrayXd> monomials = {Eigen::ArrayXd::Ones(rows)};
  std::vector<int> degrees = {0};
  for (const auto& axis : axes)
    for (std::size_t i = 0; i < monomials.size(); ++i) {  // those it appends too: its next power
      if (degrees[i] == degree) continue;
      monomials.push_back(monomials[i] * axis);
      degrees.push_back(degrees[i] + 1);
    }
  Eigen::MatrixXd columns(rows, static_cast<Eigen::Index>(monomials.size()));
  for (std::size_t i = 0; i < monomials.size(); ++i)
    columns.col(static_cast<Eigen::Index>(i)) = monomials[i].matrix();
  return problem.learned(columns);
}

double explained(const Eigen::MatrixXd& columns, const Eigen::VectorXd& series) {
  return series.squaredNorm() -
         (series - columns * columns.completeOrthogonalDecomposition().solve(series)).squaredNorm();
}

}  // namespace

Plausibility::Plausibility(const Problem& problem, const std::optional<LeverLimits>& levers)
    : problem_(problem),
      levers_(levers),
      slopes_(slopes_of(problem)),
      geometry_(geometry_of(problem)) {}

bool Plausibility::told_from_geometry(const Cause& cause, const Eigen::MatrixXd& columns,
                                      const std::vector<std::size_t>& shape,
                                      const Ground& ground) const {
  if (cause.linear != LinearParameter::offset_mm && cause.linear != LinearParameter::angle_arcsec)
    return true;
  if (geometry_.cols() > geometry_.rows() / kFewestRowsPerMonomial) return true;
  double plain = 0, beyond_geometry = 0;
  for (std::size_t o = 0; o < shape.size(); ++o) {
    const auto at = static_cast<Eigen::Index>(o);
    const auto& space = ground.space(shape[o]);
    const double sd = ground.white_sd(at);
    const Eigen::MatrixXd white = space.left_over(columns);
    const Eigen::VectorXd left = space.left_over(ground.series().col(at));
    const Eigen::MatrixXd basis = beyond(space, geometry_);
    plain += explained(white, left) / (sd * sd);
    beyond_geometry += explained(white - basis * (basis.transpose() * white),
                                 left - basis * (basis.transpose() * left)) /
                       (sd * sd);
  }
  return beyond_geometry >= kShareBeyondGeometry * plain;
}

bool Plausibility::limits(const Cause& cause) const {
  return cause.linear == LinearParameter::ppm_per_k ||
         (cause.linear == LinearParameter::offset_mm && levers_);
}

double Plausibility::largest(const Cause& cause, const effects::Term& term,
                             std::size_t output) const {
  const int tilt = read_by(term, kTilts), axis = read_by(term, kAxes);
  const auto slope = [&](int of) {
    return std::abs(slopes_(static_cast<Eigen::Index>(output), of));
  };
  switch (cause.linear) {
    case LinearParameter::ppm_per_k:  // nm per mm and K
      return kLargestExpansion_ppm_per_k;
    case LinearParameter::offset_mm: {
      if (tilt < 0 || axis >= 0) return kUnlimited;
      double nm_per_arcsec = 0;
      for (int of = 0; of < 3; ++of)
        if (slope(of) > 0)
          nm_per_arcsec +=
              slope(of) * kRadPerArcsec *
              levers_->mm[static_cast<std::size_t>(of)][static_cast<std::size_t>(tilt)];
      return nm_per_arcsec;
    }
    default:
      return kUnlimited;
  }
}

bool Plausibility::allows(const Cause& cause, const std::vector<effects::Term>& terms,
                          const Eigen::MatrixXd& columns, const std::vector<std::size_t>& shape,
                          const Ground& ground) const {
  if (!limits(cause)) return true;
  if (cause.linear == LinearParameter::ppm_per_k && terms.size() != 1) return true;
  for (std::size_t o = 0; o < problem_.outputs.size(); ++o) {
    if (problem_.outputs[o].unit != "nm" || o >= shape.size()) continue;
    const auto at = static_cast<Eigen::Index>(o);
    const auto& space = ground.space(shape[o]);
    const Eigen::MatrixXd white = space.left_over(columns);
    const Eigen::VectorXd left = space.left_over(ground.series().col(at));
    const Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> cod(white);
    if (cod.rank() < white.cols()) continue;  // nothing can be said of one alone
    const Eigen::VectorXd b = cod.solve(left);
    const Eigen::MatrixXd inverse = cod.pseudoInverse();
    for (Eigen::Index j = 0; j < b.size(); ++j) {
      const double se = ground.white_sd(at) * inverse.row(j).norm();
      if (std::abs(b[j]) - 2 * se > largest(cause, terms[static_cast<std::size_t>(j)], o))
        return false;
    }
  }
  return true;
}

}  // namespace driftwise::diagnosis
