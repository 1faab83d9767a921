#pragma once
// What a term reads of the same instant. A play or creep of a motor reads where the motor has been,
// so it may stand among that motor's own terms; the motor itself may not.

#include <string>
#include <vector>

#include "server/effects/term.h"

namespace driftwise::effects {

// Every channel symbol that the term reads other than by a path, each once. Any thread.
std::vector<std::string> symbols_read_at_once(const Term& term);

// A play, a creep, what motion heats: where the coordinate has been counts.
bool goes_along_path(const Call& call);
bool reads_path(const Term& term);

}  // namespace driftwise::effects
