#pragma once
// The LDS1000 controller of an LDS-Vector autocollimator (PROTOCOLS section 2; manual EDH0170).
//
// A command is [prefix]CC[value], one to a line. Queries repeat their command in the reply; setters
// answer nothing, and a wrong command only leaves a code, of which the last is kept until TE or TB
// reads it:
//
//   1TP 2TP   present value          TE TB    error code, with text
//   MS TS     status characters      VE       version
//   1TA 2TA   set-up                 SP KI    sampling period, integration constant; XI reads KI
//   TM TK     acquire n readings, at SP or at trigger pulses; TQ ends it; XN how many there are
//   <k>TT     stored reading k; 0TT all, a line each
//
// Values are in the unit of the set-up, in steps of a tenth of its increment. Lines end with CR, LF
// or both, whatever comes; a line beyond 255 characters is lost (error A).

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "drivers/simulated/emulators/emulator.h"
#include "drivers/simulated/emulators/line_buffer.h"
#include "drivers/simulated/emulators/switches.h"
#include "drivers/simulated/emulators/timed_line.h"

namespace driftwise::simulated {

class Lds1000Emulator : public Emulator {
 public:
  static const std::vector<SwitchDescription>& switches();
  // index: the plant's autocollimator. Throws SetupError.
  Lds1000Emulator(PlantAngles& plant, const Switches& switches, int index);

  void open(Session session, Link link, TimeNs now) override;
  void close(Session session, TimeNs now) override;
  void receive(Session session, std::string_view bytes, TimeNs now) override;

 private:
  struct Client {
    TimedLine line;
    LineBuffer input;
  };
  struct Command {
    std::string prefix, name, value;
  };
  struct Stored {
    double y = 0, z = 0;  // as displayed
  };

  void line(Session session, std::string_view text, TimeNs now);
  bool query(Session session, const Command& command, TimeNs now);
  void setter(const Command& command, TimeNs now);
  void acquire(const Command& command, TimeNs now);
  void take_reading(TimeNs due);
  void stored_lines(Session session, int first, TimeNs now);

  std::optional<int> axis_of(const Command& command);  // 1 or 2; else error B
  Stored measure(TimeNs now);
  std::string shown(double value) const;
  std::string set_up(int axis) const;
  char status(TimeNs now);
  void reply(Session session, std::string text, TimeNs now);

  PlantAngles& plant_;
  int index_;
  std::string terminator_, version_, unit_text_, increment_text_;
  bool arcsec_, hold_last_, stop_known_, extended_memory_;
  double step_;  // of the display, in its unit
  int decimals_;
  TimeNs latency_, line_gap_;
  double baud_;
  std::map<Session, Client> clients_;

  char error_ = '@';
  int sampling_ms_ = 50, integration_ms_ = 100;
  Stored last_good_;
  std::vector<Stored> stored_;
  int wanted_ = 0;  // readings still to acquire
  bool waiting_for_trigger_ = false;
  std::optional<Timeline::EventId> acquisition_;
};

}  // namespace driftwise::simulated
