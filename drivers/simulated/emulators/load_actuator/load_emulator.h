#pragma once
// The actuator that lays known weights on the pan: text lines over TCP, our own definition
// (docs/emulators.md). One line is one request and gets one reply line.
//
//   IDN?         OK <maker> <model> <serial>
//   LOAD?        OK <newton> <1 resting | 0 moving weights>
//   LOAD 2.305   OK                      then the weights move for a while
//   anything     ERR <code> <text>       1 syntax, 2 no such load, 3 busy, 4 jammed

#include <map>
#include <string>

#include "drivers/simulated/emulators/emulator.h"
#include "drivers/simulated/emulators/line_buffer.h"
#include "drivers/simulated/emulators/switches.h"

namespace driftwise::simulated {

class LoadEmulator : public Emulator {
 public:
  static const std::vector<SwitchDescription>& switches();
  // Throws SetupError: the plant has no load.
  LoadEmulator(PlantLoad& plant, const Switches& switches);

  void open(Session session, Link link, TimeNs now) override;
  void close(Session session, TimeNs now) override;
  void receive(Session session, std::string_view bytes, TimeNs now) override;

 private:
  std::string answer(const LineBuffer::Line& line, TimeNs now);

  PlantLoad& plant_;
  std::string identity_;
  TimeNs latency_;
  bool busy_is_error_;
  std::map<Session, LineBuffer> input_;
};

}  // namespace driftwise::simulated
