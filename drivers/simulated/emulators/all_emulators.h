#pragma once
// The kinds of emulated devices that driftwise-cellsim knows.

#include <vector>

#include "drivers/simulated/emulators/emulator_kind.h"

namespace driftwise::simulated {

const std::vector<EmulatorKind>& emulator_kinds();
const EmulatorKind* find_emulator_kind(std::string_view kind);  // nullptr: there is none

}  // namespace driftwise::simulated
