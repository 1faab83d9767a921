#pragma once
// A two-axis inclinometer MEAS DPL2 on RS-232. One-byte commands without an end: s stops the stream
// and comes back, S starts it, R asks for one pair while it is stopped, V for the identity; any
// other byte gets no answer. It streams after power on. X and Y are the two angles of one of the
// plant's instruments for angles, in degrees to three decimals.

#include <map>
#include <optional>
#include <string>

#include "drivers/simulated/emulators/emulator.h"
#include "drivers/simulated/emulators/switches.h"
#include "drivers/simulated/emulators/timed_line.h"
#include "drivers/simulated/plant/plant.h"

namespace driftwise::simulated {

class DplEmulator : public Emulator {
 public:
  static const std::vector<SwitchDescription>& switches();
  // index: which of the plant's angles it measures. Throws SetupError.
  DplEmulator(PlantAngles& plant, const Switches& switches, int index);

  void open(Session session, Link link, TimeNs now) override;
  void close(Session session, TimeNs now) override;
  void receive(Session session, std::string_view bytes, TimeNs now) override;

 private:
  void command(Session session, char byte, TimeNs now);
  std::string pair(TimeNs now);
  void stream_later(TimeNs now);
  void reply(Session session, const std::string& text, TimeNs now);

  PlantAngles& plant_;
  int index_;
  std::string identity_, echo_;
  double range_deg_, baud_;
  TimeNs latency_, period_;
  bool streams_;
  std::map<Session, TimedLine> clients_;
  std::optional<Timeline::EventId> next_pair_;
};

}  // namespace driftwise::simulated
