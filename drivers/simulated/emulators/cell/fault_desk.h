#pragma once
// The private control port: text lines for tests, nothing a real device has. Every line gets one
// reply line, "OK ..." or "ERR ...".
//
//   fault drop <device> [for <n> s]     cut its connections; new ones are refused for n seconds (0)
//   fault mute <device> <n> s           it hears and says nothing
//   fault garble <device> [<n> s]       its next reply arrives damaged, or all for n seconds
//   fault slow <device> <n> s           every reply comes n seconds later, until cleared
//   fault clock <device> <n> s          its own clock is set so far from cell time; 0 s: right
//   again fault break-beam [<device>]         an interferometer's beam is interrupted: lost until
//   zeroed fault wrong-power <device>          an autocollimator's beam: too little light, fault
//   wrong-position <device>       spot beyond the detector; until fault mend-beam <device> fault
//   jam, fault mend-load          the weights stick fault open-probe <input>            a
//   thermometer's wire breaks; fault mend-probe <input> fault disturb <device> <n> s [<a> nm]
//   shocks of amplitude a (60) on the interferometer fault lie <device> jump|scale|value <x>, fault
//   lie <device> constant
//                                       its (first) channel says so, in mm, nm, ohm, arcsec, degC
//                                       or N
//   fault volt <input> <volts>          an input for a voltage shows so much; mend: its sensor's
//   fault clear [<device>]              mute, garble, slow and the lie end
//   fault knock <a> nm                  somebody knocks at the table: the robot above swings by a
//   spacers <h> mm                      a person puts parts of this height between two robots; 0:
//   out substrate <rx> <ry> arcsec          a person glues a fresh substrate on, tilted by so much
//   microscope? <indent>                the indents as a microscope shows them, from this one
//   load <newton>                       a person changes the weights by hand
//   open <n> s                          a person opens the box over the robot for so long
//   pass <n> s                          so much cell time passes at once; refused while a client of
//                                       a device is connected, whose clock would jump
//   truth?                              what really is, as one line of JSON
//   time?                               cell time in ns
//   help
//
// All seconds are cell time. What only the plant can do comes in as functions: the desk knows no
// plant.

#include <functional>
#include <map>
#include <optional>
#include <string>

#include "drivers/simulated/emulators/cell/device_bench.h"
#include "drivers/simulated/emulators/line_buffer.h"

namespace driftwise::simulated {

struct FaultHooks {  // an empty one answers "ERR this cell cannot do that"
  std::function<void(std::size_t device, double refuse_s)> drop;
  // device: of the cell file, among those of its kind; false: it is not of the kind.
  std::function<bool(const std::string& device, TimeNs now)> break_beam;  // empty name: the first
  enum class Spot { good, wrong_power, wrong_position };
  std::function<bool(const std::string& device, Spot spot, TimeNs now)> set_spot;
  std::function<void(bool jammed, TimeNs now)> set_jammed;
  std::function<bool(double newton, TimeNs now)> hang;               // false: out of range
  std::function<bool(int input, bool open, TimeNs now)> open_probe;  // false: no such probe
  // An input shows this voltage; nullopt: its sensor's again. false: no such sensor.
  std::function<bool(int input, std::optional<double> volts, TimeNs now)> input_volt;
  std::function<void(TimeNs from, TimeNs until, double amplitude_nm)> disturb;
  // form: jump, scale, value or constant; empty: the truth again, of all. false: no such device.
  std::function<bool(const std::string& device, const std::string& form, double amount)> lie;
  std::function<void(double amplitude_nm, TimeNs now)> knock;
  std::function<bool(double height_mm, TimeNs now)> spacers;  // false: no such height
  std::function<bool(double rx_arcsec, double ry_arcsec, TimeNs now)>
      substrate;  // false: too steep
  // One line of JSON; empty: there is no such indent.
  std::function<std::string(int origin)> microscope_json;
  std::function<bool(double for_s, TimeNs now)> open_box;  // false: there is none
  // Why it cannot be; empty: so much cell time has passed.
  std::function<std::string(double for_s)> pass;
  std::function<std::string(TimeNs now)> truth_json;
};

class FaultDesk : public Emulator {
 public:
  FaultDesk(DeviceBench& bench, FaultHooks hooks) : bench_(bench), hooks_(std::move(hooks)) {}

  void open(Session session, Link, TimeNs) override {
    input_.insert_or_assign(session, LineBuffer());
  }
  void close(Session session, TimeNs) override { input_.erase(session); }
  void receive(Session session, std::string_view bytes, TimeNs now) override;

  std::string answer(std::string_view line, TimeNs now);

 private:
  std::string fault(const std::vector<std::string_view>& words, TimeNs now);
  // Faults of what is measured; nullopt: another kind of fault.
  std::optional<std::string> world_fault(const std::vector<std::string_view>& words, TimeNs now);
  std::string lie(const std::vector<std::string_view>& words);
  std::string volt(const std::vector<std::string_view>& words, TimeNs now);
  std::string knock(const std::vector<std::string_view>& words, TimeNs now);
  std::string spacers(const std::vector<std::string_view>& words, TimeNs now);
  std::string substrate(const std::vector<std::string_view>& words, TimeNs now);
  std::string microscope(const std::vector<std::string_view>& words);
  std::string open_box(const std::vector<std::string_view>& words, TimeNs now);
  std::string pass(const std::vector<std::string_view>& words);
  std::string hang(const std::vector<std::string_view>& words, TimeNs now);

  DeviceBench& bench_;
  FaultHooks hooks_;
  std::map<Session, LineBuffer> input_;
};

}  // namespace driftwise::simulated
