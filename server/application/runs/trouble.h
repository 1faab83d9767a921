#pragma once
// What an error in the middle of a run means for the run. Pure.

#include "server/core/result.h"

namespace driftwise::application {

enum class Remedy {
  wait_for_device,  // it comes back by itself, and the run goes on by itself
  new_datum,        // ... and the zero is lost: zero again
  hold,             // somebody stopped the axis or switched it off: a person says when it may go on
  abort,            // a person ended the run
  leave,            // the daemon ends: the run goes on with its next start
  fail,             // going on makes no sense
};

Remedy remedy_for(const Error& error);

// The actuator answers, and its weights do not come to where they should.
bool is_of_weights(const Error& error);

}  // namespace driftwise::application
