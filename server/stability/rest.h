#pragma once
// A cell at rest: since when a channel drifts by no more than a limit.

#include <optional>

#include "server/stability/drift.h"

namespace driftwise::stability {

struct RestVerdict {
  std::optional<Drift> now;         // over the last window
  std::optional<double> warm_at_s;  // on the series' clock; none: not yet
  double change = 0;                // last block minus the first one
};

// Warm since T: over the whole stretch from T on, |rate| + 2 u is at most the limit, so that the
// drift is shown to be within it; and in no window of that stretch |rate| - 2 u is beyond it. The
// stretch is at least one window long. u allows for noise that is correlated in time. Values are
// averaged to 30 blocks per window first.
RestVerdict rest_of(const Samples& series, double window_s, double limit_per_h);

}  // namespace driftwise::stability
