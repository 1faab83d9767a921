#include "tests/statistics/case_b_oracle.h"

#include <algorithm>
#include <cmath>
#include <string_view>

namespace driftwise::statistics {
namespace {

using Eigen::Index;

constexpr double kEnough_mm = 3e-6;  // below the noise of one reading by three
constexpr double kLookAlike = 1e-6;  // of a column's own length: nothing of its own is left
constexpr std::size_t kMostTerms = 100;

bool of_the_robot(std::string_view part) {
  return part == "base" || part == "top" || part == "platform" || part.starts_with("column_") ||
         part.starts_with("guide_") || part.starts_with("stage_") || part.starts_with("arms_");
}

// Every term that the plant's robot may have, of every row.
Eigen::MatrixXd library(const CaseBCampaign& campaign) {
  std::vector<Eigen::VectorXd> columns;
  const auto n = static_cast<Index>(campaign.rows.size());
  const auto of_rows = [&](auto value_of) {
    Eigen::VectorXd column(n);
    for (Index r = 0; r < n; ++r) column[r] = value_of(campaign.rows[static_cast<std::size_t>(r)]);
    return column;
  };
  using testing_support::MicroNanoRow;
  std::array<Eigen::VectorXd, 3> pose;  // as measured: nobody has another one
  for (std::size_t k = 0; k < 3; ++k)
    pose[k] = Eigen::Map<const Eigen::VectorXd>(campaign.measured.columns[3 + k].values.data(), n);
  const auto times_pose = [&](const Eigen::VectorXd& factor, int order) {
    for (int i = 0; i <= order; ++i)
      for (int j = 0; i + j <= order; ++j)
        for (int k = 0; i + j + k <= order; ++k)
          columns.push_back(pose[0].array().pow(i) * pose[1].array().pow(j) *
                            pose[2].array().pow(k) * factor.array());
  };
  const Eigen::VectorXd force = of_rows([](const MicroNanoRow& row) { return row.force_n; });
  times_pose(Eigen::VectorXd::Ones(n), 4);
  times_pose(force, 3);
  times_pose(force.array().square(), 1);
  columns.push_back(force.array().cube());
  for (std::size_t part = 0; part < campaign.part_names.size(); ++part)
    if (of_the_robot(campaign.part_names[part]))
      times_pose(of_rows([=](const MicroNanoRow& row) { return row.true_part_degc[part] - 20; }),
                 2);
  Eigen::MatrixXd all(n, static_cast<Index>(columns.size()));
  for (std::size_t c = 0; c < columns.size(); ++c) all.col(static_cast<Index>(c)) = columns[c];
  return all;
}

// Forward, the column first that takes most off y; nothing random is in y.
std::vector<Index> terms_of(const Eigen::MatrixXd& columns, const Eigen::VectorXd& y) {
  Eigen::MatrixXd left = columns.rowwise() - columns.colwise().mean();
  const Eigen::RowVectorXd length = left.colwise().norm();
  Eigen::VectorXd rest = y.array() - y.mean();
  std::vector<Index> taken;
  const double enough = kEnough_mm * std::sqrt(static_cast<double>(y.size()));
  while (rest.norm() > enough && taken.size() < kMostTerms) {
    Index best = -1;
    double most = 0;
    for (Index c = 0; c < left.cols(); ++c) {
      const double own = left.col(c).norm();
      if (own <= kLookAlike * length[c]) continue;
      const double share = std::abs(left.col(c).dot(rest)) / own;
      if (share > most) {
        most = share;
        best = c;
      }
    }
    if (best < 0) break;
    taken.push_back(best);
    const Eigen::VectorXd along = left.col(best).normalized();
    rest -= along * along.dot(rest);
    left -= along * (along.transpose() * left);
    left.col(best).setZero();
  }
  return taken;
}

}  // namespace

double robot_oracle_u90_nm(const CaseBCampaign& campaign, std::size_t axis) {
  Eigen::MatrixXd instruments(static_cast<Index>(campaign.rows.size()), 7);
  for (Index r = 0; r < instruments.rows(); ++r) {
    const auto& row = campaign.rows[static_cast<std::size_t>(r)];
    instruments.row(r) << row.true_mm[0], row.true_mm[1], row.true_mm[2], row.time_s / 3600,
        row.r_arcsec[0], row.r_arcsec[1], row.r_arcsec[2];
  }
  return u90_inside_nm(campaign,
                       left_after_calibration(campaign, instruments, campaign.instruments[axis]));
}

TermsOracle terms_oracle(const CaseBCampaign& campaign, std::size_t axis) {
  const Eigen::MatrixXd all = library(campaign);
  const auto terms = terms_of(all, campaign.robot[axis]);
  const Eigen::VectorXd q = campaign.robot[axis] + campaign.instruments[axis];
  return {u90_inside_nm(campaign, left_after_calibration(campaign, all(Eigen::all, terms), q)),
          terms.size()};
}

}  // namespace driftwise::statistics
