#pragma once
// Feeds arbitrary bytes to an emulated device, with time passing in between: 0xFF followed by one
// byte is a pause of that many 20 ms, 0xFE closes the connection and opens another; anything else
// is what a client sends. Output without bounds is a failure too.

#include <cstdint>
#include <cstdlib>
#include <string>

#include "drivers/simulated/emulators/emulator.h"

namespace driftwise::simulated {

inline void fuzz_emulator(Emulator& emulator, Link link, TimeNs now, const std::uint8_t* data,
                          std::size_t size) {
  Session session = 1;
  std::size_t sent = 0, events = 0;
  const auto run_until = [&](TimeNs until) {
    while (emulator.next_event() && *emulator.next_event() <= until) {
      if (++events > 100000) return;  // a client may ask for a scan without end
      emulator.run_next_event();
      for (const auto& output : emulator.take_output()) sent += output.bytes.size();
      if (sent > (256u << 20)) std::abort();
    }
    now = until;
  };
  emulator.open(session, link, now);
  for (std::size_t i = 0; i < size; ++i) {
    if (data[i] == 0xFF && i + 1 < size) {
      run_until(now + data[++i] * (kSecondNs / 50));
    } else if (data[i] == 0xFE) {
      emulator.close(session, now);
      emulator.open(++session, link, now);
    } else {
      const char byte = static_cast<char>(data[i]);
      emulator.receive(session, {&byte, 1}, now);
    }
  }
  run_until(now + 10 * kSecondNs);
  emulator.close(session, now);
}

}  // namespace driftwise::simulated
