#pragma once
// A kind of emulated device as it declares itself, once: in <device>/, beside its emulator. The
// list of all is all_emulators.cc.

#include <array>
#include <memory>
#include <string_view>
#include <vector>

#include "drivers/simulated/emulators/emulator.h"
#include "drivers/simulated/emulators/switches.h"
#include "drivers/simulated/plant/plant.h"

namespace driftwise::simulated {

// Physical quantities that a plant offers to devices of a kind.
enum class Quantity { axis, length, probe, angle, stabiliser, load };

// Places in the plant, handed out in the order of the cell file: the second interferometer measures
// the plant's second length.
class PlantPlaces {
 public:
  int take(Quantity quantity, int count = 1) {
    int& next = next_[static_cast<std::size_t>(quantity)];
    const int first = next;
    next += count;
    return first;
  }

 private:
  std::array<int, 6> next_{};
};

struct EmulatorKind {
  std::string_view kind, section;  // as [[device]] kind says; its switches: [emulator.<section>]
  Quantity quantity;
  const std::vector<SwitchDescription>& (*switches)();
  std::string_view serial_switch;  // also serves a pseudo-terminal when it is true; empty: cannot
  // Throws SetupError: the plant has no such place, a switch has no such value.
  std::unique_ptr<Emulator> (*make)(Plant& plant, const Switches& switches, PlantPlaces& places,
                                    TimeNs now);
  // Devices of the cell file with one address are one emulated device: the first one's.
  bool is_shared_by_address = false;
};

}  // namespace driftwise::simulated
