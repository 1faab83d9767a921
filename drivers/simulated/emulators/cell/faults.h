#pragma once
// What can go wrong between a device and whoever talks to it, for tests: the device is mute, slow,
// or its replies arrive garbled. Set by the control port (fault_desk.h).

#include <cstdint>
#include <string>

#include "drivers/simulated/emulators/timeline.h"

namespace driftwise::simulated {

struct Faults {
  TimeNs mute_until = 0;    // hears nothing and says nothing
  TimeNs slow_ns = 0;       // every reply comes later by so much
  TimeNs garble_until = 0;  // replies are damaged until then ...
  int garble_next = 0;      // ... or so many of them
  std::uint32_t random = 1;

  bool mute(TimeNs now) const { return now < mute_until; }
  bool garbles(TimeNs now);  // uses up one of garble_next
  // Some bytes replaced, some lost; ends as it ended, so that the receiver sees a line of nonsense.
  std::string garbled(std::string bytes);
};

}  // namespace driftwise::simulated
