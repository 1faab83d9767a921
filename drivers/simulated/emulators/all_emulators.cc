// The list of emulators, one line each: the folder's name. CMake reads it too. Each folder's code
// defines `const EmulatorKind emulator_kind::<folder>`.

#include "drivers/simulated/emulators/all_emulators.h"

#include <algorithm>

// clang-format off
#define DRIFTWISE_EMULATORS(EMULATOR) \
  EMULATOR(pi_gcs)                    \
  EMULATOR(keithley_2701)             \
  EMULATOR(interferometer_adapter)    \
  EMULATOR(watlow_ez_zone)            \
  EMULATOR(lds1000)                   \
  EMULATOR(load_actuator)             \
  EMULATOR(inclinometer)              \
  EMULATOR(touch_probe)               \
  // end of the list
// clang-format on

namespace driftwise::simulated {

#define DECLARED(folder) extern const EmulatorKind folder;
namespace emulator_kind {
DRIFTWISE_EMULATORS(DECLARED)
}
#undef DECLARED

#define LISTED(folder) emulator_kind::folder,
const std::vector<EmulatorKind>& emulator_kinds() {
  static const std::vector<EmulatorKind> kAll{DRIFTWISE_EMULATORS(LISTED)};
  return kAll;
}
#undef LISTED

const EmulatorKind* find_emulator_kind(std::string_view kind) {
  const auto found = std::ranges::find(emulator_kinds(), kind, &EmulatorKind::kind);
  return found == emulator_kinds().end() ? nullptr : &*found;
}

}  // namespace driftwise::simulated
