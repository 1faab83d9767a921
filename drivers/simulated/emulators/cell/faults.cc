#include "drivers/simulated/emulators/cell/faults.h"

namespace driftwise::simulated {

bool Faults::garbles(TimeNs now) {
  if (now < garble_until) return true;
  if (garble_next == 0) return false;
  --garble_next;
  return true;
}

std::string Faults::garbled(std::string bytes) {
  std::string out;
  bool changed = false;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    random = random * 1664525u +
             1013904223u;  // Numerical Recipes' generator: the same damage on every machine
    const bool last = i + 1 == bytes.size();
    const std::uint32_t dice = random >> 16;
    if (!last && (dice % 5 == 0 || !changed)) {
      changed = true;
      if (dice % 3 != 0) out += static_cast<char>(dice % 96 + 32);
    } else {
      out += bytes[i];
    }
  }
  return out;
}

}  // namespace driftwise::simulated
