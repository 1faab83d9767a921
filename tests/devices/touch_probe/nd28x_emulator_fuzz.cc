#include "drivers/simulated/emulators/touch_probe/nd28x_emulator.h"
#include "tests/fuzz/emulators/emulator_harness.h"
#include "tests/unit/emulators/conversation.h"
#include "tests/unit/emulators/test_plant.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace driftwise::simulated;
  TestPlant plant;
  Nd28xEmulator emulator(plant, switches_with(Nd28xEmulator::switches(), {}), 0);
  fuzz_emulator(emulator, Link::serial, kStart, data, size);
  return 0;
}
