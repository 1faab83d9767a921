#include "drivers/simulated/emulators/pi_gcs/pi_gcs_emulator.h"
#include "tests/fuzz/emulators/emulator_harness.h"
#include "tests/unit/emulators/conversation.h"
#include "tests/unit/emulators/test_plant.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace driftwise::simulated;
  TestPlant plant(3);
  PiGcsEmulator emulator(plant, 0, switches_with(PiGcsEmulator::switches(), {{"axes", "X,Y,Z"}}),
                         kStart);
  fuzz_emulator(emulator, Link::tcp, kStart, data, size);
  return 0;
}
