#pragma once
// What must hold before a run takes its first point. Each check fails with a sentence that says
// what to do.

#include "server/application/motion/workbench.h"

namespace driftwise::application {

// Permission to give drives without current their current by homing. A servo that is off although
// the axes are referenced was switched off on purpose, by an emergency stop for instance.
enum class SwitchOn : std::uint8_t {
  no,               // it was used, or nobody gave it
  if_unreferenced,  // a run that begins or continues by itself: the power of the controller was
                    // away
  yes,              // a person has asked for motion just now
};

// Every thermometer gave a value within the maximum age; waits for the first scan, at most three of
// the scanner's periods. Errors, failed_precondition: CHANNEL_MISSING, CHANNEL_TOO_OLD.
Awaitable<Result<void>> check_thermometers(RunScope& scope);

// Every stabiliser is within the band of its set-point. Waits (state waiting) up to
// stabiliser_wait_s. Errors: failed_precondition STABILISER_OFF.
Awaitable<Result<void>> check_stabilisers(RunScope& scope);

// The instrument against the scale at rest, over drift_window_s; measured again (state waiting)
// while too fast, as long as the start may wait. Errors: failed_precondition DRIFT_TOO_FAST.
Awaitable<Result<void>> check_drift(RunScope& scope);

// References the axes when they are not, when a servo is off, or when it is asked for anyway (after
// a kill). Errors besides: failed_precondition SERVO_OFF, a servo is off and homing may not switch
// it on.
Awaitable<Result<void>> make_homed(RunScope& scope, bool in_any_case, SwitchOn switch_on);

// The two halves of it. True: they are to be homed, and nothing is in the way. By hand the axes are
// halted where the second one fails, as in go_to.
Awaitable<Result<bool>> clear_to_home(RunScope& scope, bool in_any_case, SwitchOn switch_on);
Awaitable<Result<void>> send_home(RunScope& scope);

// Error SERVO_OFF, with what a person does about it.
Error servo_is_off();

}  // namespace driftwise::application
