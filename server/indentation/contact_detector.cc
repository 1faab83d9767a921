#include "server/indentation/contact_detector.h"

#include <algorithm>
#include <string>
#include <vector>

#include "server/core/reasons.h"

namespace driftwise::indentation {
namespace {

Eigen::VectorXd medians(const Eigen::MatrixXd& rows) {
  Eigen::VectorXd middle(rows.rows());
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    std::vector<double> values;
    for (Eigen::Index k = 0; k < rows.cols(); ++k) values.push_back(rows(i, k));
    std::ranges::sort(values);
    middle[i] = (values[(values.size() - 1) / 2] + values[values.size() / 2]) / 2;
  }
  return middle;
}

}  // namespace

Result<ContactDetector::Verdict> ContactDetector::add(
    const Eigen::Ref<const Eigen::MatrixXd>& holding_error_nm) {
  const auto axes = holding_error_nm.cols();
  if (holding_error_nm.rows() == 0 || axes == 0 || !holding_error_nm.allFinite())
    return fail(ErrorCode::invalid_argument, reasons::kBadValue,
                "a look at the holding error has " + std::to_string(holding_error_nm.rows()) +
                    " readings of " + std::to_string(axes) +
                    " axes, or one that is not a number: read the controller's positions again");
  if (baseline_nm_.cols() > 0 && baseline_nm_.rows() != axes)
    return fail(ErrorCode::invalid_argument, reasons::kBadValue,
                "a look at the holding error has " + std::to_string(axes) +
                    " axes, the first one " + std::to_string(baseline_nm_.rows()) +
                    ": read the same axes every time");
  const Eigen::VectorXd mean_nm = holding_error_nm.colwise().mean().transpose();
  if (baseline_nm_.cols() < rule_.baseline_windows) {
    baseline_nm_.conservativeResize(axes, baseline_nm_.cols() + 1);
    baseline_nm_.rightCols(1) = mean_nm;
    if (baseline_nm_.cols() == rule_.baseline_windows) middle_nm_ = medians(baseline_nm_);
    return Verdict::baseline;
  }
  shift_nm_ = mean_nm - middle_nm_;
  const bool beyond = shift_nm_.cwiseAbs().maxCoeff() > rule_.abort_nm;
  const int side = shift_nm_.minCoeff() >= rule_.threshold_nm    ? 1
                   : shift_nm_.maxCoeff() <= -rule_.threshold_nm ? -1
                                                                 : 0;
  const bool again = side != 0 && side == side_before_;
  const bool beyond_again = beyond && beyond_before_;
  side_before_ = side;
  beyond_before_ = beyond;
  if (beyond_again) return Verdict::abort;
  if (beyond) return Verdict::look_again;
  if (again) return Verdict::contact;
  return side != 0 ? Verdict::look_again : Verdict::free;
}

}  // namespace driftwise::indentation
