#pragma once
// States of runs and jobs as the end of a sentence: "run 3 is paused", "diagnosis 2 has failed".

#include <string>

#include "server/core/records/diagnosis_records.h"
#include "server/core/records/records.h"

namespace driftwise {

template <class State>
std::string is_text(State state) {
  return state == State::failed ? "has failed" : "is " + std::string(to_string(state));
}

}  // namespace driftwise
