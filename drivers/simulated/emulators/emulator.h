#pragma once
// One emulated device: a protocol state machine without sockets. Bytes come in at an instant of
// cell time, bytes go out with the instant at which the device would send them. The caller keeps
// the order of time: before it hands over bytes received at `now` it runs every event that is due
// by then (Cell does so for all devices together, because they share one plant whose time never
// runs back).
//
// A session is one connection: a TCP client or the serial line. What a device keeps per connection
// (half a line) and what it keeps for all (the error queue) is its own affair. One thread; nothing
// here throws on what a client sends.

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "drivers/simulated/emulators/timeline.h"

namespace driftwise::simulated {

using Session = int;
enum class Link { tcp, serial };

struct Output {
  Session session;
  TimeNs at;
  std::string bytes;
};

class Emulator {
 public:
  virtual ~Emulator() = default;
  Emulator() = default;
  Emulator(const Emulator&) = delete;
  Emulator& operator=(const Emulator&) = delete;

  virtual void open(Session session, Link link, TimeNs now) = 0;
  virtual void close(Session session, TimeNs now) = 0;
  virtual void receive(Session session, std::string_view bytes, TimeNs now) = 0;

  // Sets the device's own clock so far from cell time. False: it has none.
  virtual bool set_clock(TimeNs ahead) {
    static_cast<void>(ahead);
    return false;
  }

  std::optional<TimeNs> next_event() const { return timeline_.next(); }
  void run_next_event() { timeline_.run_next(); }
  // What was sent since the last call, in order of time.
  std::vector<Output> take_output() { return std::exchange(output_, {}); }

 protected:
  void send(Session session, std::string bytes, TimeNs now) {
    output_.push_back({session, now, std::move(bytes)});
  }
  Timeline timeline_;

 private:
  std::vector<Output> output_;
};

}  // namespace driftwise::simulated
