#pragma once
// Contact of two robots, seen in the holding error of the one that holds still: commanded minus
// read-back position of each of its axes. A robot at rest keeps an error of tens of nanometres; the
// other robot's step against it shifts all axes to one side.
//
// A window is one look: N readings (rows) of all axes (columns), nm. Its mean is compared with the
// median of the windows that were seen before the approach: one that was knocked does not shift it.
// Contact: every axis is off by the threshold or more, all to one side, in two consecutive windows
// on the same side. Pure; one thread. Source: E. Lubrano, EPFL thesis 5098 (2011), section 8.2:
// +-25 to 35 nm at rest, a step of 200 to 250 nm at contact; the threshold is 3 to 5 times the
// first and half of the second.

#include <Eigen/Core>

#include "server/core/result.h"

namespace driftwise::indentation {

struct ContactRule {
  double threshold_nm = 125;
  double abort_nm = 1000;    // an axis off by more, in two consecutive windows: something is wrong
  int baseline_windows = 5;  // before the approach
};

class ContactDetector {
 public:
  enum class Verdict {
    baseline,    // one more window of the baseline was taken
    free,        // no contact
    look_again,  // the next window decides; nothing may move before it
    contact,
    abort,  // the error is beyond the limit, twice
  };

  explicit ContactDetector(ContactRule rule) : rule_(rule) {}

  // Errors: invalid_argument BAD_VALUE (no readings, not finite, another number of axes than
  // before).
  Result<Verdict> add(const Eigen::Ref<const Eigen::MatrixXd>& holding_error_nm);

  // Mean of the last window minus the baseline's median, per axis; empty before the baseline is
  // complete.
  const Eigen::VectorXd& shift_nm() const { return shift_nm_; }

 private:
  ContactRule rule_;
  Eigen::MatrixXd baseline_nm_;  // a column per window
  Eigen::VectorXd middle_nm_;    // its medians
  Eigen::VectorXd shift_nm_;
  int side_before_ = 0;  // of a window over the threshold; 0: it was not
  bool beyond_before_ = false;
};

}  // namespace driftwise::indentation
