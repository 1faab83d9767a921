#pragma once
// The force on the end-effector: what is known of it, and how it gets to another value.
//
// A cell with a load actuator asks it; without one a person hangs known weights and says so, and
// the run waits meanwhile. What a person said is stored at once as a reading of device "operator",
// so that a restart knows what still hangs there. Executor's thread.

#include <optional>
#include <string>

#include "server/application/motion/workbench.h"

namespace driftwise::application {

inline constexpr const char* kOperatorDevice = "operator";
// The run's phase while weights are on their way.
inline constexpr const char* kChangingTheForce = "changing the force";

// Two forces that no weight could tell apart.
bool same_force(double a_n, double b_n);

// "hang 2.305 N (235 g)", "take every weight off: 0 N".
std::string hang_sentence(double force_n, const LoadDescription& load);

// Errors, out_of_range FORCE_LIMIT: asked, limit, what to do; failed_precondition NO_LOAD: the cell
// knows no force.
Result<void> check_force(const CellDescription& description, double force_n);

class Loading {
 public:
  // What acts now; none: nobody has said since the cell was set up.
  const std::optional<double>& known_n() const { return known_n_; }
  void know(double force_n) { known_n_ = force_n; }

  // Makes the force act, or does nothing when it does already. With an actuator: commands it and
  // waits until it rests there. Without: run state waiting, until RunControl::confirm_force.
  // Errors: those of check_force and of the actuator; deadline_exceeded LOAD_SLOW; aborted,
  // cancelled.
  Awaitable<Result<void>> bring_to(RunScope& scope, double force_n);

  // Asks the actuator, where there is one, what acts now.
  Awaitable<Result<void>> look(DeviceBench& devices);

 private:
  Awaitable<Result<void>> by_actuator(RunScope& scope, double force_n);
  Awaitable<Result<void>> by_person(RunScope& scope, double force_n);

  std::optional<double> known_n_;
};

}  // namespace driftwise::application
