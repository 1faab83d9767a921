#include "server/indentation/contact_detector.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "server/core/reasons.h"

namespace driftwise::indentation {
namespace {

constexpr double kDeviations = 6;        // of a window's common shift: a faint sign
constexpr int kFaintWindows = 4;         // 5 s: ten decay times of a table on its feet
constexpr std::size_t kRemembered = 20;  // windows for the standard deviation
// No faint sign below this share of the threshold: few windows know their own scatter badly.
constexpr double kLeastShare = 0.1;
constexpr double kShareOfEachAxis = 0.5;

double median_of(std::vector<double> values) {
  std::ranges::sort(values);
  return (values[(values.size() - 1) / 2] + values[values.size() / 2]) / 2;
}

Eigen::VectorXd medians(const std::deque<Eigen::VectorXd>& windows) {
  Eigen::VectorXd middle(windows.front().size());
  for (Eigen::Index axis = 0; axis < middle.size(); ++axis) {
    std::vector<double> values;
    for (const auto& window : windows) values.push_back(window[axis]);
    middle[axis] = median_of(std::move(values));
  }
  return middle;
}

// Normal standard deviation by the median of the absolute deviations.
double robust_deviation(const std::deque<double>& values) {
  constexpr double kOfMedian = 1.4826;
  const double middle = median_of({values.begin(), values.end()});
  std::vector<double> off;
  for (const double value : values) off.push_back(std::abs(value - middle));
  return kOfMedian * median_of(std::move(off));
}

// Standard deviation of the window's common mean, by the readings of the window itself.
double within_window(const Eigen::Ref<const Eigen::MatrixXd>& readings) {
  const auto count = readings.rows();
  if (count < 2) return 0;
  const Eigen::VectorXd common = readings.rowwise().mean();
  const double squares = (common.array() - common.mean()).square().sum();
  return std::sqrt(squares / static_cast<double>(count - 1) / static_cast<double>(count));
}

}  // namespace

int ContactDetector::clear_side() const {
  if (shift_nm_.minCoeff() >= rule_.threshold_nm) return 1;
  return shift_nm_.maxCoeff() <= -rule_.threshold_nm ? -1 : 0;
}

int ContactDetector::faint_side() const {
  const double common_nm = shift_nm_.mean();
  if (std::abs(common_nm) < faint_nm_) return 0;
  const int side = common_nm > 0 ? 1 : -1;
  return (side * shift_nm_).minCoeff() >= kShareOfEachAxis * std::abs(common_nm) ? side : 0;
}

void ContactDetector::learn_scatter() {
  while (common_nm_.size() > kRemembered) common_nm_.pop_front();
  const double deviation_nm =
      std::max(robust_deviation(common_nm_), median_of({within_nm_.begin(), within_nm_.end()}));
  faint_nm_ = std::max(kLeastShare * rule_.threshold_nm, kDeviations * deviation_nm);
}

// What looked like a contact and was none.
void ContactDetector::take_refuted() {
  if (pending_nm_.empty()) return;
  common_nm_.insert(common_nm_.end(), pending_nm_.begin(), pending_nm_.end());
  pending_nm_.clear();
  learn_scatter();
}

void ContactDetector::take_as_free(const Eigen::VectorXd& mean_nm, double within_nm) {
  const auto keep = [](auto& values, std::size_t count) {
    while (values.size() > count) values.pop_front();
  };
  free_nm_.push_back(mean_nm);
  keep(free_nm_, static_cast<std::size_t>(rule_.baseline_windows));
  common_nm_.push_back(mean_nm.mean());
  within_nm_.push_back(within_nm);
  keep(within_nm_, kRemembered);
  middle_nm_ = medians(free_nm_);
  learn_scatter();
}

Result<ContactDetector::Verdict> ContactDetector::add(
    const Eigen::Ref<const Eigen::MatrixXd>& holding_error_nm) {
  const auto axes = holding_error_nm.cols();
  if (holding_error_nm.rows() == 0 || axes == 0 || !holding_error_nm.allFinite())
    return fail(ErrorCode::invalid_argument, reasons::kBadValue,
                "a look at the holding error has " + std::to_string(holding_error_nm.rows()) +
                    " readings of " + std::to_string(axes) +
                    " axes, or one that is not a number: read the controller's positions again");
  if (axes_ > 0 && axes_ != axes)
    return fail(ErrorCode::invalid_argument, reasons::kBadValue,
                "a look at the holding error has " + std::to_string(axes) +
                    " axes, the first one " + std::to_string(axes_) +
                    ": read the same axes every time");
  axes_ = axes;
  const Eigen::VectorXd mean_nm = holding_error_nm.colwise().mean().transpose();
  const double within_nm = within_window(holding_error_nm);
  if (free_nm_.size() < static_cast<std::size_t>(rule_.baseline_windows)) {
    take_as_free(mean_nm, within_nm);
    return Verdict::baseline;
  }
  shift_nm_ = mean_nm - middle_nm_;
  const bool beyond = shift_nm_.cwiseAbs().maxCoeff() > rule_.abort_nm;
  const int clear = clear_side();
  const int side = clear != 0 ? clear : faint_side();
  const bool same_side = side != 0 && side == side_before_;
  if (!same_side) take_refuted();
  windows_on_side_ = same_side ? windows_on_side_ + 1 : side != 0 ? 1 : 0;
  const bool clear_again = clear != 0 && clear_before_ && same_side;
  const bool beyond_again = beyond && beyond_before_;
  side_before_ = side;
  clear_before_ = clear != 0;
  beyond_before_ = beyond;
  if (beyond_again) return Verdict::abort;
  if (beyond) return Verdict::look_again;
  if (clear_again || windows_on_side_ >= kFaintWindows) return Verdict::contact;
  looks_ = side != 0 ? looks_ + 1 : 0;
  if (looks_ >= kMostLooks) return Verdict::abort;
  if (side != 0) {
    pending_nm_.push_back(mean_nm.mean());
    return Verdict::look_again;
  }
  take_as_free(mean_nm, within_nm);
  return Verdict::free;
}

}  // namespace driftwise::indentation
