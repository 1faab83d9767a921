#include "drivers/simulated/emulators/interferometer_adapter/interferometer_emulator.h"
#include "tests/fuzz/emulators/emulator_harness.h"
#include "tests/unit/emulators/conversation.h"
#include "tests/unit/emulators/test_plant.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace driftwise::simulated;
  TestPlant plant;
  InterferometerEmulator emulator(
      plant, switches_with(InterferometerEmulator::switches(), {{"channels", "2"}}), 0);
  fuzz_emulator(emulator, Link::tcp, kStart, data, size);
  return 0;
}
