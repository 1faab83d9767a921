#include "server/calibration/linear/undetermined.h"

#include <algorithm>

namespace driftwise::calibration {
namespace {

constexpr double kAlreadyThere = 1e-4;  // NUMERICS.md section 3: what keeps less is there already
constexpr double kRounding = 1e-13;     // of a column's length: a constant that is no power of two

}  // namespace

std::vector<char> undetermined(const Eigen::MatrixXd& columns, Eigen::Index kept) {
  std::vector<char> result(static_cast<std::size_t>(columns.cols()), 0);
  Eigen::MatrixXd basis(columns.rows(), columns.cols());
  Eigen::Index count = 0;
  for (Eigen::Index j = 0; j < columns.cols(); ++j) {
    Eigen::VectorXd rest = columns.col(j);
    const double whole = rest.norm();
    double varies = whole;
    if (j >= kept) varies = (rest.array() - rest.mean()).matrix().norm();
    for (int pass = 0; pass < 2; ++pass)  // twice is enough
      rest -= basis.leftCols(count) * (basis.leftCols(count).transpose() * rest).eval();
    const double length = rest.norm();
    if (length > std::max(kAlreadyThere * varies, kRounding * whole))
      basis.col(count++) = rest / length;
    else
      result[static_cast<std::size_t>(j)] = j >= kept;
  }
  return result;
}

}  // namespace driftwise::calibration
