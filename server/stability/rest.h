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
// stretch is at least one window long: its values span nine tenths of one. u allows for noise that
// is correlated in time. Values are averaged to 30 blocks per window first. A window is what lies
// less than window_s before its last block, whatever the number of blocks with values; from 8 on it
// is judged. A hole longer than a quarter of a window ends the stretch: what the channel did
// meanwhile is not known.
RestVerdict rest_of(const Samples& series, double window_s, double limit_per_h);

}  // namespace driftwise::stability
