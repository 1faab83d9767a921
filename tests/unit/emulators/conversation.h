#pragma once
// Talking to an emulator without sockets, in verbs. Time passes only when the test says so.

#include <initializer_list>
#include <string>
#include <utility>

#include "drivers/simulated/emulators/emulator.h"
#include "drivers/simulated/emulators/switches.h"

namespace driftwise::simulated {

using Settings = std::initializer_list<std::pair<const char*, const char*>>;

inline Switches switches_with(const std::vector<SwitchDescription>& declared, Settings settings) {
  Switches switches("[emulator.test]", declared);
  for (const auto& [name, value] : settings) switches.set(name, value);
  return switches;
}

constexpr TimeNs kStart = 1'700'000'000 * kSecondNs;

class Conversation {
 public:
  explicit Conversation(Emulator& emulator, Link link = Link::tcp) : emulator_(emulator) {
    emulator_.open(1, link, now);
  }
  void say(std::string_view bytes) { emulator_.receive(1, bytes, now); }
  // Lets time pass and gives what was sent meanwhile.
  std::string hear(double seconds = 1.0) {
    const TimeNs until = now + nanoseconds_from(seconds);
    std::string out;
    while (emulator_.next_event() && *emulator_.next_event() <= until) {
      now = *emulator_.next_event();
      emulator_.run_next_event();
      collect(out);
    }
    now = until;
    collect(out);
    return out;
  }
  std::string ask(std::string_view bytes, double seconds = 1.0) {
    say(bytes);
    return hear(seconds);
  }
  TimeNs last_sent = 0;  // when the last bytes left
  TimeNs now = kStart;

 private:
  void collect(std::string& out) {
    for (const auto& output : emulator_.take_output()) {
      if (output.session != 1) continue;
      last_sent = output.at;
      out += output.bytes;
    }
  }
  Emulator& emulator_;
};

}  // namespace driftwise::simulated
