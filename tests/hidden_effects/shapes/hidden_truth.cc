#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "server/calibration/design/predict.h"
#include "server/diagnosis/catalogue/cause.h"
#include "server/formats/formula/formula.h"
#include "tests/hidden_effects/shapes/hidden_case.h"

namespace driftwise::hidden {
namespace {

// Whitened by the true covariance, at the calibration rows, freed of the baseline.
class TrueSpace {
 public:
  TrueSpace(const HiddenData& made, const std::vector<effects::Term>& base)
      : made_(made), cholesky_(made.covariance) {
    const Eigen::MatrixXd white = cholesky_.matrixL().solve(columns(base));
    const Eigen::VectorXd scale = white.colwise().norm();
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(white * scale.cwiseInverse().asDiagonal());
    basis_ = qr.householderQ() * Eigen::MatrixXd::Identity(white.rows(), qr.rank());
  }
  Eigen::MatrixXd columns(const std::vector<effects::Term>& terms) const {
    const Eigen::MatrixXd all = *calibration::raw_columns(made_.data, terms);
    return rows(all);
  }
  Eigen::MatrixXd rows(const Eigen::MatrixXd& all) const {
    Eigen::MatrixXd taken(static_cast<Eigen::Index>(made_.calibration.size()), all.cols());
    for (std::size_t i = 0; i < made_.calibration.size(); ++i)
      taken.row(static_cast<Eigen::Index>(i)) =
          all.row(static_cast<Eigen::Index>(made_.calibration[i]));
    return taken;
  }
  Eigen::MatrixXd whitened(const Eigen::MatrixXd& c) const {
    return cholesky_.matrixL().solve(c.rowwise() - c.colwise().mean());
  }
  Eigen::MatrixXd left_over(const Eigen::MatrixXd& c) const {
    Eigen::MatrixXd white = whitened(c);
    white -= basis_ * (basis_.transpose() * white).eval();
    return white;
  }

 private:
  const HiddenData& made_;
  Eigen::LLT<Eigen::MatrixXd> cholesky_;
  Eigen::MatrixXd basis_;
};

// The part of each truth column that these columns do not explain, squared and summed.
double unexplained(Eigen::MatrixXd columns, const Eigen::MatrixXd& truth,
                   const std::vector<char>& on) {
  Eigen::MatrixXd left = truth;
  for (Eigen::Index j = 0; j < columns.cols(); ++j) {
    for (Eigen::Index k = 0; k < j; ++k)
      columns.col(j) -= columns.col(k).dot(columns.col(j)) * columns.col(k);
    const double length = columns.col(j).norm();
    if (!(length > 1e-9)) continue;
    columns.col(j) /= length;
    for (Eigen::Index o = 0; o < truth.cols(); ++o)
      if (on[static_cast<std::size_t>(o)] != 0)
        left.col(o) -= columns.col(j).dot(left.col(o)) * columns.col(j);
  }
  return left.squaredNorm();
}

std::vector<char> outputs_of(const diagnosis::Cause& cause, Eigen::Index count) {
  std::vector<char> on;
  for (Eigen::Index o = 0; o < count; ++o)
    on.push_back(cause.outputs.empty() ||
                 std::ranges::find(cause.outputs, "q" + std::to_string(o + 1)) !=
                     cause.outputs.end());
  return on;
}

std::optional<double> bound_of(const TrueSpace& space, const diagnosis::Cause& cause,
                               double parameter, const Eigen::MatrixXd& truth) {
  constexpr double kStep = 1e-3;
  const auto& terms = cause.cells.front().terms;
  const auto at = [&](double value) {
    return space.left_over(space.columns(diagnosis::with_parameter(terms, value)));
  };
  const Eigen::MatrixXd here = at(parameter);
  const Eigen::MatrixXd slope =
      (at(parameter * (1 + kStep)) - at(parameter * (1 - kStep))) / (2 * kStep * parameter);
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(here);
  double information = 0;
  for (Eigen::Index o = 0; o < truth.cols(); ++o) {
    const Eigen::VectorXd v = slope * qr.solve(truth.col(o));
    information += (v - here * qr.solve(v)).squaredNorm();
  }
  if (!(information > 0)) return std::nullopt;
  return 1 / std::sqrt(information);
}

}  // namespace

Truth truth_of(const HiddenData& made) {
  const Hidden& hidden = made.hidden.front();
  const auto baseline = *formats::Formula::parse(made.baseline)->expand(made.data);
  std::vector<effects::Term> base = {effects::Term{}};
  base.insert(base.end(), baseline.terms.begin(), baseline.terms.end());
  const TrueSpace space(made, base);
  const Eigen::MatrixXd truth = space.left_over(space.rows(made.effect_nm));
  Truth result;
  result.identifiable = truth.squaredNorm();
  for (const auto& cause : diagnosis::catalogue_for(made.data, base, {}).causes) {
    if (cause.id == hidden.cause) {
      const bool continuous = cause.scale == diagnosis::ParameterScale::logarithmic ||
                              cause.scale == diagnosis::ParameterScale::inverse;
      if (cause.subject == hidden.subject && hidden.parameter > 0 && continuous)
        result.bound_sd = bound_of(space, cause, hidden.parameter, truth);
      continue;
    }
    std::vector<effects::Term> terms;
    for (const auto& cell : cause.cells)
      terms.insert(terms.end(), cell.terms.begin(), cell.terms.end());
    const Eigen::MatrixXd left = space.left_over(space.columns(terms));
    const auto on = outputs_of(cause, truth.cols());
    Eigen::Index at = 0;
    for (const auto& cell : cause.cells) {
      const auto width = static_cast<Eigen::Index>(cell.terms.size());
      result.identifiable =
          std::min(result.identifiable, unexplained(left.middleCols(at, width), truth, on));
      at += width;
    }
  }
  return result;
}

}  // namespace driftwise::hidden
