#pragma once
// What must hold before a run takes its first point. Each check fails with a sentence that says
// what to do.

#include "server/application/motion/workbench.h"

namespace driftwise::application {

// Every thermometer gave a value within the maximum age; waits for the first scan, at most three of
// the scanner's periods. Errors, failed_precondition: CHANNEL_MISSING, CHANNEL_TOO_OLD.
Awaitable<Result<void>> check_thermometers(RunScope& scope);

// Every stabiliser is within the band of its set-point. Waits (state waiting) up to
// stabiliser_wait_s. Errors: failed_precondition STABILISER_OFF.
Awaitable<Result<void>> check_stabilisers(RunScope& scope);

// The instrument against the scale at rest, over drift_window_s; measured again (state waiting)
// while too fast, as long as the start may wait. Errors: failed_precondition DRIFT_TOO_FAST.
Awaitable<Result<void>> check_drift(RunScope& scope);

// References the axes when they are not, or when it is asked for anyway (after a kill).
Awaitable<Result<void>> make_homed(RunScope& scope, bool in_any_case);

}  // namespace driftwise::application
