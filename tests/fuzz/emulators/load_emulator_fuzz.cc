#include "drivers/simulated/emulators/load_actuator/load_emulator.h"
#include "tests/fuzz/emulators/emulator_harness.h"
#include "tests/unit/emulators/conversation.h"
#include "tests/unit/emulators/test_plant.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace driftwise::simulated;
  TestPlant plant;
  LoadEmulator emulator(plant, switches_with(LoadEmulator::switches(), {}));
  fuzz_emulator(emulator, Link::tcp, kStart, data, size);
  return 0;
}
