#pragma once
// The private control port: text lines for tests, nothing a real device has. Every line gets one
// reply line, "OK ..." or "ERR ...".
//
//   fault drop <device> [for <n> s]       cut its connections; new ones are refused for n seconds
//   (0) fault mute <device> <n> s             it hears and says nothing fault garble <device> [<n>
//   s]         its next reply arrives damaged, or all for n seconds fault slow <device> <n> s every
//   reply comes n seconds later, until cleared fault break-beam                      the
//   interferometer's beam is interrupted: lost until zeroed fault open-probe <input>              a
//   thermometer's wire breaks; fault mend-probe <input> fault disturb <device> <n> s [<a> nm]
//   shocks of amplitude a (60) on the interferometer fault clear [<device>]                mute,
//   garble and slow end truth?                                what really is, as one line of JSON
//   time?                                 cell time in ns
//   help
//
// All seconds are cell time. What only the plant can do comes in as functions: the desk knows no
// plant.

#include <functional>
#include <map>
#include <string>

#include "drivers/simulated/emulators/device_bench.h"
#include "drivers/simulated/emulators/line_buffer.h"

namespace driftwise::simulated {

struct FaultHooks {  // an empty one answers "ERR this cell cannot do that"
  std::function<void(std::size_t device, double refuse_s)> drop;
  std::function<void(TimeNs now)> break_beam;
  std::function<bool(int input, bool open, TimeNs now)> open_probe;  // false: no such probe
  std::function<void(TimeNs from, TimeNs until, double amplitude_nm)> disturb;
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

  DeviceBench& bench_;
  FaultHooks hooks_;
  std::map<Session, LineBuffer> input_;
};

}  // namespace driftwise::simulated
