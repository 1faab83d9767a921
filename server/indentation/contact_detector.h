#pragma once
// Contact of two robots, seen in the holding error of the one that holds still: commanded minus
// read-back position of each of its axes. A robot at rest keeps an error of tens of nanometres; the
// other robot's step against it shifts all axes to one side.
//
// A window is one look: N readings (rows) of all axes (columns), nm. Its mean is compared with the
// median of the last windows without contact: one that was knocked does not shift it, and a slow
// drift goes with it. The first windows, the rest, are taken as free without being judged: whoever
// adds them knows that the robots are apart. Two ways to a contact:
// - clear: every axis is off by the threshold or more, all to one side, in two consecutive windows.
// - faint: the sum over the axes is off by six of its own standard deviations, as the windows
//   without contact have them, and every axis has at least half of the mean shift on that side, in
//   four consecutive windows. A knock rings through zero and is gone by then; an axis that latches
//   elsewhere does not move the others. The sum is the matched statistic of a shift that all axes
//   share; the four windows are the sequential test's agreement.
// Windows whose sign the next ones refute are no contact: they enter the standard deviation (not
// the median), so that a disturbance that begins after the baseline is learnt. kMostLooks windows
// with a sign and no contact in succession are no holding error: abort.
// A step of 250 nm that ends 20 nm beyond the surface shows in the second way only.
//
// Pure; one thread. Source of the threshold: E. Lubrano, EPFL thesis 5098 (2011), section 8.2:
// +-25 to 35 nm at rest, a step of 200 to 250 nm at contact; the threshold is 3 to 5 times the
// first and half of the second.

#include <Eigen/Core>
#include <deque>

#include "server/core/result.h"

namespace driftwise::indentation {

struct ContactRule {
  double threshold_nm = 125;
  double abort_nm = 1000;    // an axis off by more, in two consecutive windows: something is wrong
  int baseline_windows = 5;  // of the rest, apart; and later, of the last windows without contact
};

constexpr int kMostLooks = 40;  // at one height

class ContactDetector {
 public:
  enum class Verdict {
    baseline,    // one more window of the rest was taken, unjudged
    free,        // no contact
    look_again,  // the next window decides; nothing may move before it
    contact,
    abort,  // the error is beyond the limit, twice; or restless for kMostLooks windows
  };

  explicit ContactDetector(ContactRule rule) : rule_(rule) {}

  // Errors: invalid_argument BAD_VALUE (no readings, not finite, another number of axes than
  // before).
  Result<Verdict> add(const Eigen::Ref<const Eigen::MatrixXd>& holding_error_nm);

  // Mean of the last window minus the baseline's median, per axis; empty before the baseline is
  // complete.
  const Eigen::VectorXd& shift_nm() const { return shift_nm_; }
  // Mean shift of the axes from which a window counts as a faint sign.
  double faint_nm() const { return faint_nm_; }
  // Side of the sign that the last window gave: 1, -1; 0: none.
  int side() const { return side_before_; }

 private:
  int clear_side() const;
  int faint_side() const;
  void take_as_free(const Eigen::VectorXd& mean_nm, double within_nm);
  void take_refuted();
  void learn_scatter();

  ContactRule rule_;
  Eigen::Index axes_ = 0;
  std::deque<Eigen::VectorXd> free_nm_;  // means of the last windows without contact
  std::deque<double> common_nm_;         // their mean over the axes, further back
  std::deque<double> within_nm_;         // standard deviation of such a mean by its own readings
  Eigen::VectorXd middle_nm_;            // median of free_nm_, per axis
  Eigen::VectorXd shift_nm_;
  std::deque<double> pending_nm_;  // means over the axes of the windows on the present side
  double faint_nm_ = 0;
  int looks_ = 0;  // windows with a sign, in succession
  int side_before_ = 0, windows_on_side_ = 0;
  bool clear_before_ = false, beyond_before_ = false;
};

}  // namespace driftwise::indentation
