#include "drivers/simulated/emulators/cell/fault_desk.h"
#include "tests/fuzz/emulators/emulator_harness.h"
#include "tests/unit/emulators/conversation.h"
#include "tests/unit/emulators/test_plant.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace driftwise::simulated;
  TestPlant plant;
  DeviceBench bench(plant);
  bench.add("laser-x", nullptr);
  FaultDesk desk(bench, {});
  fuzz_emulator(desk, Link::tcp, kStart, data, size);
  return 0;
}
