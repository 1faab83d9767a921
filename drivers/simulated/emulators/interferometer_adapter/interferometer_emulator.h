#pragma once
// The adapter process of a laser interferometer: text lines over TCP (PROTOCOLS section 3). One
// line is one request and gets one reply line, "OK ..." or "ERR <code> <text>"; requests are
// case-blind, ended by LF (a CR before it is ignored), and those of one connection are answered in
// order, each after the one before has been answered.
//
//   IDN?  AVG n (2048 4096 8192 16384)  ZERO mask  DEADPATH ch mm  MEAS? ch
//
// MEAS? takes n / rate seconds and answers with its own begin and end, t0 and t1, as unix seconds
// with nine decimals. After a beam break it answers ERR 3 until the channel is zeroed. Errors: 1
// syntax, 2 no device (or no such channel), 3 beam break, 4 timeout, 5 overflow, 6 laser unstable.

#include <deque>
#include <map>
#include <string>

#include "drivers/simulated/emulators/emulator.h"
#include "drivers/simulated/emulators/line_buffer.h"
#include "drivers/simulated/emulators/switches.h"

namespace driftwise::simulated {

class InterferometerEmulator : public Emulator {
 public:
  static const std::vector<SwitchDescription>& switches();
  // first: the plant's interferometer behind channel 1. Throws SetupError.
  InterferometerEmulator(PlantLengths& plant, const Switches& switches, int first);

  void open(Session session, Link link, TimeNs now) override;
  void close(Session session, TimeNs now) override;
  void receive(Session session, std::string_view bytes, TimeNs now) override;
  bool set_clock(TimeNs ahead) override {
    clock_ahead_ = ahead;
    return true;
  }

 private:
  struct Client {
    LineBuffer input;
    std::deque<LineBuffer::Line> waiting;
    bool busy = false;
    std::uint64_t serial = 0;  // tells a new client from an old one with the same session number
  };

  void start_next(Session session, Client& client, TimeNs now);
  std::string answer(const LineBuffer::Line& line, TimeNs now);  // empty: a measurement was started
  void measure(Session session, int channel, TimeNs start);
  std::string measured(int channel, TimeNs start, int samples, TimeNs now);
  void finish(Session session, std::uint64_t serial, const std::string& reply, TimeNs now);
  std::optional<int> channel(std::string_view text) const;  // 1..channels

  PlantLengths& plant_;
  int first_, channels_, samples_;
  std::string identity_;
  TimeNs latency_;
  TimeNs clock_ahead_ = 0;  // of cell time
  bool unstable_is_error_;
  std::map<Session, Client> clients_;
  std::uint64_t last_serial_ = 0;
};

}  // namespace driftwise::simulated
