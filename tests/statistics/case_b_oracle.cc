#include "tests/statistics/case_b_oracle.h"

#include <Eigen/QR>
#include <cmath>
#include <stdexcept>

#include "server/calibration/predict.h"
#include "server/formats/formula.h"
#include "tests/statistics/micro_nano_case.h"

namespace driftwise::statistics {
namespace {

using Eigen::Index;
using testing_support::MicroNanoRow;

constexpr int kValidationInside = 2;  // the grid at 0.768 N; that at 3.842 N lies outside
constexpr double kU90 = 1.645;

double u90_nm(const std::vector<double>& errors_mm) {
  double mean = 0, squares = 0;
  for (const double e : errors_mm) mean += e / static_cast<double>(errors_mm.size());
  for (const double e : errors_mm) squares += (e - mean) * (e - mean);
  return 1e6 * kU90 * std::sqrt(squares / static_cast<double>(errors_mm.size() - 1));
}

// Gradient of the scale by the true pose: a cubic, which is enough for a Jacobian.
Eigen::MatrixXd jacobian(const std::vector<MicroNanoRow>& rows, std::size_t axis) {
  const auto n = static_cast<Index>(rows.size());
  std::vector<std::array<int, 3>> powers;
  for (int i = 0; i <= 3; ++i)
    for (int j = 0; i + j <= 3; ++j)
      for (int k = 0; i + j + k <= 3; ++k) powers.push_back({i, j, k});
  const auto term = [](const MicroNanoRow& row, const std::array<int, 3>& p) {
    return std::pow(row.true_mm[0], p[0]) * std::pow(row.true_mm[1], p[1]) *
           std::pow(row.true_mm[2], p[2]);
  };
  Eigen::MatrixXd columns(n, static_cast<Index>(powers.size()) + 2);
  Eigen::VectorXd q(n);
  for (Index r = 0; r < n; ++r) {
    const auto& row = rows[static_cast<std::size_t>(r)];
    for (std::size_t c = 0; c < powers.size(); ++c)
      columns(r, static_cast<Index>(c)) = term(row, powers[c]);
    columns(r, columns.cols() - 2) = row.t_degc[9] - 20;
    columns(r, columns.cols() - 1) = row.force_n;
    q[r] = row.true_q_mm[axis];
  }
  const Eigen::VectorXd b = columns.colPivHouseholderQr().solve(q);
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(n, 3);
  for (Index r = 0; r < n; ++r)
    for (std::size_t c = 0; c < powers.size(); ++c)
      for (std::size_t k = 0; k < 3; ++k) {
        auto lower = powers[c];
        if (lower[k]-- == 0) continue;
        out(r, static_cast<Index>(k)) += b[static_cast<Index>(c)] * powers[c][k] *
                                         term(rows[static_cast<std::size_t>(r)], lower);
      }
  return out;
}

double oracle_u90_nm(const std::vector<MicroNanoRow>& rows, const Dataset& data, std::size_t axis) {
  const auto slope = jacobian(rows, axis);
  const auto n = static_cast<Index>(rows.size());
  Eigen::MatrixXd instruments(n, 8);
  Eigen::VectorXd left(n);
  std::vector<Index> fitted;
  for (Index r = 0; r < n; ++r) {
    const auto i = static_cast<std::size_t>(r);
    const auto& row = rows[i];
    double known = row.true_q_mm[axis];
    for (std::size_t k = 0; k < 3; ++k)
      known += slope(r, static_cast<Index>(k)) * (data.columns[3 + k].values[i] - row.true_mm[k]);
    left[r] = row.q_mm[axis] - known;
    instruments.row(r) << 1, row.true_mm[0], row.true_mm[1], row.true_mm[2], row.time_s / 3600,
        row.r_arcsec[0], row.r_arcsec[1], row.r_arcsec[2];
    if (row.calibration) fitted.push_back(r);
  }
  const Eigen::VectorXd b =
      Eigen::MatrixXd(instruments(fitted, Eigen::all)).colPivHouseholderQr().solve(left(fitted));
  const Eigen::VectorXd error = left - instruments * b;
  std::vector<double> errors;
  for (Index r = 0; r < n; ++r)
    if (rows[static_cast<std::size_t>(r)].grid == kValidationInside) errors.push_back(error[r]);
  return u90_nm(errors);
}

}  // namespace

const std::vector<CaseBModel>& case_b_models() {
  static const std::vector<CaseBModel> models = {
      {"G", "q ~ poly(x, y, z, 3)"},
      {"G+F", "q ~ poly(x, y, z, 3) + F + F^2 + F^3"},
      {"G+T", "q ~ poly(x, y, z, 3) + t04..t10"},
      {"G+T+F", "q ~ poly(x, y, z, 3) + F + F^2 + F^3 + t04..t10"},
      {"cross",
       "q ~ poly(x, y, z, 4) + F + F^2 + F^3 + t04..t10 + F:poly(x, y, z, 3) + "
       "t10:poly(x, y, z, 3)"},
  };
  return models;
}

CaseBFigures case_b_figures(std::uint64_t seed) {
  testing_support::MicroNanoOptions options;
  options.seed = seed;
  options.coarse = true;
  const auto rows = testing_support::run_micro_nano_campaign(DRIFTWISE_SOURCE_DIR, options);
  const auto data = micro_nano_dataset(rows, micro_nano_cell());
  CaseBFigures figures;
  for (const auto& asked : case_b_models()) {
    const auto model = formats::fit_formula(data, asked.formula, {});
    if (!model) throw std::runtime_error(model.error().message);
    auto& u90 = figures.models.emplace_back();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto predicted = calibration::predict(data, model->outputs[axis]);
      if (!predicted) throw std::runtime_error(predicted.error().message);
      std::vector<double> errors;
      for (std::size_t r = 0; r < rows.size(); ++r)
        if (rows[r].grid == kValidationInside)
          errors.push_back(rows[r].q_mm[axis] - (*predicted)[static_cast<Index>(r)]);
      u90[axis] = u90_nm(errors);
    }
  }
  for (std::size_t axis = 0; axis < 3; ++axis)
    figures.oracle[axis] = oracle_u90_nm(rows, data, axis);
  return figures;
}

}  // namespace driftwise::statistics
