#include "server/diagnosis/noise/own_rows.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace driftwise::diagnosis {
namespace {

constexpr double kLeastOfRow = 1e-3;   // of an impulse's length that the simulation leaves
constexpr Eigen::Index kAtOnce = 256;  // impulses: they stay in the cache
constexpr double kOwn = 0.5;           // of what a row is off, beyond the farther ones

// Whitened, freed of the simulation, of unit length; its length before.
Eigen::MatrixXd impulses(const WhitenedSpace& space, Eigen::Index rows,
                         const std::vector<Eigen::Index>& at, Eigen::VectorXd& length) {
  const auto count = static_cast<Eigen::Index>(at.size());
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(rows, count);
  for (Eigen::Index k = 0; k < count; ++k) result(at[static_cast<std::size_t>(k)], k) = 1;
  result = space.left_over(std::move(result));
  length = result.colwise().norm();
  for (Eigen::Index k = 0; k < count; ++k) {
    if (length[k] < kLeastOfRow) length[k] = 0;
    result.col(k) *= length[k] > 0 ? 1 / length[k] : 0;
  }
  return result;
}

}  // namespace

OwnRows own_rows(const WhitenedSpace& space, const Eigen::MatrixXd& whitened) {
  const Eigen::Index n = whitened.rows();
  OwnRows own{Eigen::MatrixXd(n, whitened.cols()), Eigen::VectorXd(n)};
  for (Eigen::Index first = 0; first < n; first += kAtOnce) {
    std::vector<Eigen::Index> at;
    for (Eigen::Index i = first; i < std::min(n, first + kAtOnce); ++i) at.push_back(i);
    Eigen::VectorXd length;
    const Eigen::MatrixXd columns = impulses(space, n, at, length);
    own.off.middleRows(first, columns.cols()) = columns.transpose() * whitened;
    own.length.segment(first, columns.cols()) = length;
  }
  return own;
}

std::vector<Eigen::Index> beyond_the_farther(const WhitenedSpace& space,
                                             const Eigen::Ref<const Eigen::VectorXd>& off,
                                             std::vector<Eigen::Index> rows) {
  if (rows.empty()) return rows;
  std::ranges::sort(rows, std::ranges::greater{}, [&](Eigen::Index i) { return std::abs(off[i]); });
  Eigen::VectorXd length;
  const Eigen::MatrixXd columns = impulses(space, off.size(), rows, length);
  const Eigen::MatrixXd products = columns.transpose() * columns;
  std::vector<Eigen::Index> taken, kept;  // places in `rows`; rows
  for (Eigen::Index k = 0; k < columns.cols(); ++k) {
    const Eigen::Index row = rows[static_cast<std::size_t>(k)];
    double left = off[row];
    if (!taken.empty()) {
      const Eigen::MatrixXd among = products(taken, taken);
      const Eigen::VectorXd shared = products(taken, k);
      left -= shared.dot(Eigen::VectorXd(among.ldlt().solve(off(kept))));
    }
    if (std::abs(left) < kOwn * std::abs(off[row])) continue;
    taken.push_back(k);
    kept.push_back(row);
  }
  std::ranges::sort(kept);
  return kept;
}

}  // namespace driftwise::diagnosis
