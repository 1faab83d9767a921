#include "drivers/simulated/emulators/inclinometer/dpl_emulator.h"

#include <algorithm>
#include <cstdio>

#include "drivers/simulated/emulators/emulator_kind.h"

namespace driftwise::simulated {
namespace {

constexpr double kAverage_s = 0.1;
constexpr double kArcsecPerDegree = 3600;

// "X=+01.234"
std::string dpl_line(char axis, double degrees) {
  char text[32];
  std::snprintf(text, sizeof text, "%c=%+07.3f\r\n", axis, degrees);
  return text;
}

}  // namespace

const std::vector<SwitchDescription>& DplEmulator::switches() {
  static const std::vector<SwitchDescription> kAll{
      {"version", "DPL2 V1.8.0", "M", "first line of the answer to V"},
      {"serial_number", "12345678", "M", "what stands behind SN: in the second line"},
      {"streams", "true", "M", "sends pairs by itself after power on, until s"},
      {"stream_period_s", "0.1", "U", "between two pairs of the stream"},
      {"echo_line_end", "false", "U", "the echo of s is followed by a line end"},
      {"range_deg", "30", "U", "largest value that is sent, whatever the tilt"},
      {"latency_s", "0.02", "own", "from a command to its answer"},
      {"serial", "false", "own", "also serve a pseudo-terminal (printed in READY): RS-232, 8N1"},
      {"serial_baud", "9600", "U", "RS-232 bytes take 10 bits each; 0: no time"},
      {"max_clients", "1", "own", "TCP connections at a time; one more is closed at once"},
  };
  return kAll;
}

DplEmulator::DplEmulator(PlantAngles& plant, const Switches& s, int index)
    : plant_(plant),
      index_(index),
      identity_(s.text("version") + "\r\nSN:" + s.text("serial_number") + "\r\n"),
      echo_(s.flag("echo_line_end") ? "s\r\n" : "s"),
      range_deg_(s.number("range_deg", 0.1, 180)),
      baud_(s.number("serial_baud", 0, 1e6)),
      latency_(nanoseconds_from(s.number("latency_s", 0, 10))),
      period_(nanoseconds_from(s.number("stream_period_s", 0.01, 10))),
      streams_(s.flag("streams")) {
  if (index < 0 || index >= plant.collimator_count())
    throw SetupError("[emulator.inclinometer]: asked for the plant's angles " +
                     std::to_string(index + 1) + ", it has " +
                     std::to_string(plant.collimator_count()));
}

void DplEmulator::open(Session session, Link link, TimeNs now) {
  clients_.insert_or_assign(session, TimedLine(link));
  stream_later(now);
}

void DplEmulator::close(Session session, TimeNs) { clients_.erase(session); }

void DplEmulator::receive(Session session, std::string_view bytes, TimeNs now) {
  if (!clients_.contains(session)) return;
  for (const char byte : bytes) command(session, byte, now);
}

void DplEmulator::command(Session session, char byte, TimeNs now) {
  if (byte == 's') {
    streams_ = false;
    if (next_pair_) timeline_.cancel(*next_pair_);
    next_pair_.reset();
    reply(session, echo_, now);
  } else if (byte == 'S') {
    streams_ = true;
    stream_later(now);
  } else if (byte == 'R' && !streams_) {
    reply(session, pair(now), now);
  } else if (byte == 'V') {
    reply(session, identity_, now);
  }
}

std::string DplEmulator::pair(TimeNs now) {
  const AngleReading reading = plant_.measure_angle(index_, kAverage_s, now);
  const auto shown_deg = [this](double arcsec) {
    return std::clamp(arcsec / kArcsecPerDegree, -range_deg_, range_deg_);
  };
  return dpl_line('X', shown_deg(reading.y_arcsec)) + dpl_line('Y', shown_deg(reading.z_arcsec));
}

void DplEmulator::stream_later(TimeNs now) {
  if (!streams_ || next_pair_ || clients_.empty()) return;
  next_pair_ = timeline_.at(now + period_, [this](TimeNs due) {
    next_pair_.reset();
    if (clients_.empty()) return;
    const std::string text = pair(due);
    for (const auto& [session, client] : clients_) reply(session, text, due);
    stream_later(due);
  });
}

void DplEmulator::reply(Session session, const std::string& text, TimeNs now) {
  const TimeNs due = clients_.at(session).carry(text.size(), baud_, now + latency_);
  timeline_.at(due, [this, session, text](TimeNs at) {
    if (clients_.contains(session)) send(session, text, at);
  });
}

namespace emulator_kind {

extern const EmulatorKind inclinometer;
const EmulatorKind inclinometer{
    .kind = "meas-dpl",
    .section = "inclinometer",
    .quantity = Quantity::angle,
    .switches = DplEmulator::switches,
    .serial_switch = "serial",
    .make = [](Plant& plant, const Switches& switches, PlantPlaces& places,
               TimeNs) -> std::unique_ptr<Emulator> {
      return std::make_unique<DplEmulator>(plant, switches, places.take(Quantity::angle));
    }};

}  // namespace emulator_kind

}  // namespace driftwise::simulated
