#pragma once
// A motion controller that speaks PI GCS 2.0 (PROTOCOLS section 8): text lines ended by LF, replies
// of several lines with a blank before every LF but the last, single-byte requests that need no LF
// and overtake what is being typed, silent setters, and one error number that ERR? reads and
// clears.
//
// Errors kept for ERR?: 0 ok, 1 syntax, 2 unknown command, 5 not referenced or servo off, 7
// position limit, 8 velocity limit, 10 stopped, 15 unknown axis, 17 parameter range, 24 too many
// parameters, 26 parameter missing. A query that fails gives no line at all. A move starts
// start_delay_s after MOV was accepted.

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/simulated/emulators/emulator.h"
#include "drivers/simulated/emulators/line_buffer.h"
#include "drivers/simulated/emulators/switches.h"

namespace driftwise::simulated {

class PiGcsEmulator : public Emulator {
 public:
  static const std::vector<SwitchDescription>& switches();
  // Drives the plant's axes from first_axis on, one for each of its axis names; several controllers
  // share a plant. Throws SetupError: a switch out of range, more axis names than the plant has
  // axes.
  PiGcsEmulator(PlantAxes& plant, int first_axis, const Switches& switches, TimeNs power_on);

  void open(Session session, Link link, TimeNs now) override;
  void close(Session session, TimeNs now) override;
  void receive(Session session, std::string_view bytes, TimeNs now) override;

 private:
  using Words = std::span<const std::string_view>;
  struct Pair {
    int axis;
    double value;
  };
  struct PendingStart {
    Timeline::EventId event;
    std::vector<Pair> targets;
  };

  void single_byte(Session session, unsigned char byte, TimeNs now);
  void line(Session session, const LineBuffer::Line& line, TimeNs now);
  void query(Session session, const std::string& name, Words words, TimeNs now);
  void setter(const std::string& name, Words words, TimeNs now);

  void move(Words words, bool relative, TimeNs now);
  void set_servo(Words words, TimeNs now);
  void reference(Words words, TimeNs now);
  void set_velocity(Words words, bool system, TimeNs now);
  void halt(TimeNs now);

  int error(int number);  // keeps it for ERR?; returns it
  std::optional<int> axis_index(std::string_view name) const;
  std::optional<std::vector<int>> axes(Words words);    // none named: all
  std::optional<std::vector<Pair>> pairs(Words words);  // "X 1.5 Y 0"
  bool all_referenced(TimeNs now);
  bool any_referencing(TimeNs now);
  template <class Value>
  void reply_per_axis(Session session, Words words, TimeNs now, Value value);
  void reply(Session session, std::string text, TimeNs now);  // after the controller's latency

  int axis_count() const { return static_cast<int>(names_.size()); }
  AxisState axis_state(int axis, TimeNs now) { return plant_.axis(first_axis_ + axis, now); }
  AxisTravel axis_travel(int axis) const { return plant_.axis_travel(first_axis_ + axis); }

  PlantAxes& plant_;
  int first_axis_;
  std::vector<std::string> names_;
  std::string identity_, status_prefix_, ready_, busy_;
  bool stale_on_target_, keep_first_error_, ini_known_, limits_known_, vls_known_, vel_known_,
      vmo_single_, mask_follows_start_;
  int decimals_;
  TimeNs start_delay_, latency_;
  double max_velocity_;

  std::map<Session, LineBuffer> input_;
  std::vector<double> target_mm_, velocity_mm_s_;
  std::vector<bool> servo_;
  std::optional<PendingStart> pending_;
  int error_ = 0;
};

// "X=0.1000000 \nY=0.0000000\n": a blank before every LF but the last tells that more follows.
template <class Value>
void PiGcsEmulator::reply_per_axis(Session session, Words words, TimeNs now, Value value) {
  const auto wanted = axes(words);
  if (!wanted) return;
  std::string text;
  for (const int axis : *wanted) {
    if (!text.empty()) text += " \n";
    text += names_[static_cast<std::size_t>(axis)] + "=" + value(axis);
  }
  reply(session, text + "\n", now);
}

}  // namespace driftwise::simulated
