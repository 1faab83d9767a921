#include "drivers/simulated/emulators/keithley_2701/keithley_emulator.h"
#include "tests/fuzz/emulators/emulator_harness.h"
#include "tests/unit/emulators/conversation.h"
#include "tests/unit/emulators/test_plant.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace driftwise::simulated;
  if (size == 0) return 0;
  TestPlant plant;
  KeithleyEmulator emulator(
      plant,
      switches_with(KeithleyEmulator::switches(), {{"interrupt", data[0] % 2 ? "true" : "false"}}),
      kStart);
  fuzz_emulator(emulator, data[0] & 2 ? Link::serial : Link::tcp, kStart, data + 1, size - 1);
  return 0;
}
