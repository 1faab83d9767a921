#include "drivers/simulated/emulators/lds1000/lds1000_emulator.h"
#include "tests/fuzz/emulators/emulator_harness.h"
#include "tests/unit/emulators/conversation.h"
#include "tests/unit/emulators/test_plant.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace driftwise::simulated;
  TestPlant plant;
  Lds1000Emulator emulator(plant, switches_with(Lds1000Emulator::switches(), {{"unit", "sec"}}), 0);
  fuzz_emulator(emulator, Link::tcp, kStart, data, size);
  return 0;
}
