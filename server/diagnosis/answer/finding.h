#pragma once
// One cause that a diagnosis names: what it is, how large, how sure, and what it is worth.
//
// Units: a length in nm, an angle in arcsec, anything else in the output's own unit (summary_unit);
// coefficients in the output's own unit per unit of the term, as a fit has them. Signs are those of
// the output: a motor coordinate, or the channel on the left of the baseline.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "server/core/data/accuracy.h"
#include "server/effects/effect.h"
#include "server/effects/term.h"

namespace driftwise::diagnosis {

struct Interval {
  double low = 0, high = 0;
};

struct CurvePoint {  // of a profile likelihood
  double value = 0;
  double below_2lnl = 0;  // 2 ln L below its maximum, 0 or more
};

// "tau_s", "period_nm", "width_nm", "time_s": not linear, found by search, shared by all outputs,
// with a curve. "nm_per_k", "offset_mm", ...: linear; where several outputs show the cause each has
// its own, "nm_per_k_q1".
struct FoundParameter {
  std::string name{};
  double value = 0;
  std::optional<Interval> ci90{};
  std::vector<CurvePoint> curve{};  // ascending in value; empty for a linear one
  std::vector<double> aliases{};    // of a period: others that these places cannot tell from it
};

struct FindingOutput {
  std::string output{}, unit{};
  double amplitude = 0;  // rms over the calibration rows of what it adds to the rest
  double gain_2lnl = 0;  // of this output
  bool shown = false;    // this output by itself shows the cause
  std::optional<double> u90_before{}, u90_after{};  // on rows held out; none: no gain of its own
  std::optional<Interval> u90_after_ci90{};
  std::vector<double> coefficients{};  // one per term of the finding
  // Of an instrument's error: rms over the calibration rows of the correction that it would make,
  // and U90 of how far that may be off (correction_reach.h).
  std::optional<double> correction_rms{}, correction_u90{};
  // With the U90 above, figures of server/core/data/accuracy.h: A90 decides.
  std::optional<double> mean_before{}, mean_after{}, a90_before{}, a90_after{};
  std::optional<Interval> a90_after_ci90{};

  // Figures of the held-out rows without the finding and with it.
  void judge(const ErrorFigures& before, const ErrorFigures& after) {
    u90_before = before.u90, u90_after = after.u90;
    mean_before = before.mean, mean_after = after.mean;
    a90_before = before.a90, a90_after = after.a90;
  }
};

inline constexpr double kSmallestP = 1e-300;  // that is printed: 0 would be a rule, not a chance

struct Finding {
  std::string cause{};    // id of the catalogue: "thermal_lag"
  std::string subject{};  // "t07", "q1", "x"; "" where there is none
  std::string where{};    // robot, instrument, environment, sensor or data
  effects::AppliesTo applies_to = effects::AppliesTo::robot;
  std::vector<FoundParameter> parameters{};
  std::vector<effects::Term> terms{};  // what extends the simulation; none for a fault of the data
  std::vector<std::size_t> rows{};     // of the dataset, ascending: the wrong ones
  double p_adjusted = 1;               // for the search over causes and parameters
  double log_likelihood_ratio = 0;
  std::vector<std::string> indistinguishable_from{};  // "self_heating q1"
  std::vector<FindingOutput> outputs{};               // every output that it may act on
  std::string sentence{};
};

// An instrument's error whose correction would be known worse than the discrepancy is large, and
// not to a quarter of its own size either: a name, but nothing to be accepted.
bool correction_is_uncertain(const Finding& finding);

}  // namespace driftwise::diagnosis
