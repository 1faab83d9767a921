#include "tests/statistics/case_b_campaign.h"

#include <Eigen/QR>
#include <cmath>

#include "tests/statistics/micro_nano_case.h"

namespace driftwise::statistics {
namespace {

using Eigen::Index;
using testing_support::MicroNanoRow;

constexpr int kValidationInside = 2;  // the grid at 0.768 N; that at 3.842 N lies outside
constexpr double kU90 = 1.645;

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

}  // namespace

CaseBCampaign case_b_campaign(std::uint64_t seed) {
  testing_support::MicroNanoOptions options;
  options.seed = seed;
  options.coarse = true;
  testing_support::MicroNanoSession session(DRIFTWISE_SOURCE_DIR, options);
  CaseBCampaign campaign;
  campaign.rows = session.run_grids();
  campaign.measured = micro_nano_dataset(campaign.rows, micro_nano_cell());
  for (const auto& part : session.plant().parameters().parts)
    campaign.part_names.push_back(part.name);
  const auto n = static_cast<Index>(campaign.rows.size());
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto slope = jacobian(campaign.rows, axis);
    auto& robot = campaign.robot[axis];
    auto& instruments = campaign.instruments[axis];
    robot.resize(n);
    instruments.resize(n);
    for (Index r = 0; r < n; ++r) {
      const auto i = static_cast<std::size_t>(r);
      const auto& row = campaign.rows[i];
      robot[r] = row.true_q_mm[axis];
      for (std::size_t k = 0; k < 3; ++k)
        robot[r] += slope(r, static_cast<Index>(k)) *
                    (campaign.measured.columns[3 + k].values[i] - row.true_mm[k]);
      instruments[r] = row.q_mm[axis] - robot[r];
    }
  }
  return campaign;
}

double u90_inside_nm(const CaseBCampaign& campaign, const Eigen::VectorXd& errors_mm) {
  std::vector<Index> inside;
  for (std::size_t r = 0; r < campaign.rows.size(); ++r)
    if (campaign.rows[r].grid == kValidationInside) inside.push_back(static_cast<Index>(r));
  const Eigen::VectorXd errors = errors_mm(inside);
  const double squares = (errors.array() - errors.mean()).square().sum();
  return 1e6 * kU90 * std::sqrt(squares / static_cast<double>(errors.size() - 1));
}

Eigen::VectorXd left_after_calibration(const CaseBCampaign& campaign,
                                       const Eigen::MatrixXd& columns, const Eigen::VectorXd& y) {
  std::vector<Index> calibration;
  for (std::size_t r = 0; r < campaign.rows.size(); ++r)
    if (campaign.rows[r].calibration) calibration.push_back(static_cast<Index>(r));
  const Eigen::MatrixXd fitted = columns(calibration, Eigen::all);
  const Eigen::RowVectorXd middle = fitted.colwise().mean();
  const Eigen::RowVectorXd size =
      (fitted.rowwise() - middle).colwise().norm().cwiseMax(1e-300).cwiseInverse();
  Eigen::MatrixXd scaled(columns.rows(), columns.cols() + 1);
  scaled.col(0).setOnes();
  scaled.rightCols(columns.cols()) = (columns.rowwise() - middle).array().rowwise() * size.array();
  const Eigen::VectorXd b =
      Eigen::MatrixXd(scaled(calibration, Eigen::all)).colPivHouseholderQr().solve(y(calibration));
  return y - scaled * b;
}

}  // namespace driftwise::statistics
