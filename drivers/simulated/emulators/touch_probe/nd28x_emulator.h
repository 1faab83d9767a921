#pragma once
// A touch probe behind a Heidenhain ND 28x read-out on RS-232. The byte 02 asks for the present
// value; ESC, a letter, four digits and CR is a remote command: A0000 identity, A0100 display text,
// anything else is answered with NAK. Other bytes get no answer. The value is one of the plant's
// lengths in mm, in steps of the read-out, as a record of 17 characters; while the plant says that
// nothing is measured there the tip stands at its free end.

#include <map>
#include <string>

#include "drivers/simulated/emulators/emulator.h"
#include "drivers/simulated/emulators/switches.h"
#include "drivers/simulated/emulators/timed_line.h"
#include "drivers/simulated/plant/plant.h"

namespace driftwise::simulated {

class Nd28xEmulator : public Emulator {
 public:
  static const std::vector<SwitchDescription>& switches();
  // index: which of the plant's lengths it measures. Throws SetupError.
  Nd28xEmulator(PlantLengths& plant, const Switches& switches, int index);

  void open(Session session, Link link, TimeNs now) override;
  void close(Session session, TimeNs now) override;
  void receive(Session session, std::string_view bytes, TimeNs now) override;

 private:
  struct Client {
    TimedLine line;
    std::string command;  // begun with ESC, not yet ended
  };
  void command(Session session, const std::string& text, TimeNs now);
  double shown_mm(TimeNs now);
  std::string value_line(double mm) const;
  void reply(Session session, const std::string& text, TimeNs now);

  PlantLengths& plant_;
  int index_;
  std::string identity_, message_, marks_;
  bool remote_, inches_;
  double step_mm_, offset_mm_, free_mm_, baud_;
  TimeNs latency_;
  std::map<Session, Client> clients_;
};

}  // namespace driftwise::simulated
