#include "drivers/simulated/emulators/touch_probe/nd28x_emulator.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "drivers/simulated/emulators/emulator_kind.h"

namespace driftwise::simulated {
namespace {

constexpr char kPrint = '\x02', kEscape = '\x1b';
constexpr std::size_t kCommandLength = 6;  // ESC, letter, four digits
constexpr std::size_t kMarks = 3;          // unit, sorting, series
constexpr double kNmPerMillimetre = 1e6, kMmPerInch = 25.4;

}  // namespace

const std::vector<SwitchDescription>& Nd28xEmulator::switches() {
  static const std::vector<SwitchDescription> kAll{
      {"identity", "ND 287    ", "U", "first line of the answer to A0000, ten characters"},
      {"remote", "true", "M", "knows the commands that begin with ESC; false: as the ND 281B"},
      {"step_nm", "50", "M", "display step: 5 or 50 with the probe of the study"},
      {"offset_mm", "0", "own", "what it shows where the plant's length is 0"},
      {"free_mm", "-5.5", "own", "what it shows while the tip touches nothing"},
      {"inches", "false", "M", "shows inches, marked with \""},
      {"marks", "", "M", "columns behind the value: unit, sorting, series; missing ones are blank"},
      {"message", "", "U", "shown in the place of a value, such as SIGNAL X"},
      {"latency_s", "0.03", "M", "from the byte 02 to the value: at most 0.05"},
      {"serial", "false", "own", "also serve a pseudo-terminal (printed in READY): RS-232, 7E1"},
      {"serial_baud", "9600", "M", "RS-232 bytes take 10 bits each; 0: no time"},
      {"max_clients", "1", "own", "TCP connections at a time; one more is closed at once"},
  };
  return kAll;
}

Nd28xEmulator::Nd28xEmulator(PlantLengths& plant, const Switches& s, int index)
    : plant_(plant),
      index_(index),
      identity_("\x02" + s.text("identity") + "\r\n349797-05 \r\nV1.02     \r\n"),
      message_(s.text("message")),
      marks_(s.text("marks")),
      remote_(s.flag("remote")),
      inches_(s.flag("inches")),
      step_mm_(s.number("step_nm", 1, 1e6) / kNmPerMillimetre),
      offset_mm_(s.number("offset_mm", -1000, 1000)),
      free_mm_(s.number("free_mm", -1000, 1000)),
      baud_(s.number("serial_baud", 0, 1e6)),
      latency_(nanoseconds_from(s.number("latency_s", 0, 10))) {
  if (marks_.size() > kMarks)
    throw SetupError("[emulator.touch_probe]: marks = '" + marks_ +
                     "', expected up to three characters");
  marks_.resize(kMarks, ' ');
  if (inches_) marks_.front() = '"';
  if (index < 0 || index >= plant.interferometer_count())
    throw SetupError("[emulator.touch_probe]: asked for the plant's length " +
                     std::to_string(index + 1) + ", it has " +
                     std::to_string(plant.interferometer_count()));
}

void Nd28xEmulator::open(Session session, Link link, TimeNs) {
  clients_.insert_or_assign(session, Client{TimedLine(link), {}});
}

void Nd28xEmulator::close(Session session, TimeNs) { clients_.erase(session); }

void Nd28xEmulator::receive(Session session, std::string_view bytes, TimeNs now) {
  const auto found = clients_.find(session);
  if (found == clients_.end()) return;
  std::string& open_command = found->second.command;
  for (const char byte : bytes) {
    if (byte == kPrint) {
      open_command.clear();
      reply(session, message_.empty() ? value_line(shown_mm(now)) : message_ + "\r\n", now);
    } else if (byte == kEscape) {
      open_command = byte;
    } else if (byte == '\r' && !open_command.empty()) {
      const std::string text = std::exchange(open_command, {});
      if (remote_) command(session, text, now);
    } else if (!open_command.empty() && open_command.size() < kCommandLength) {
      open_command += byte;
    } else {
      open_command.clear();
    }
  }
}

void Nd28xEmulator::command(Session session, const std::string& text, TimeNs now) {
  if (text == std::string(1, kEscape) + "A0000")
    reply(session, identity_, now);
  else if (text == std::string(1, kEscape) + "A0100")
    reply(session, kPrint + (message_.empty() ? value_line(shown_mm(now)) : message_ + "\r\n"),
          now);
  else
    reply(session, "\x15", now);
}

double Nd28xEmulator::shown_mm(TimeNs now) {
  constexpr int kOneSample = 1;
  const TimeNs start = now - nanoseconds_from(kOneSample / plant_.sample_rate_hz());
  const LengthReading length = plant_.measure_length(index_, start, kOneSample);
  if (length.beam_broken) return free_mm_;
  return step_mm_ * std::round((offset_mm_ + length.mean_nm / kNmPerMillimetre) / step_mm_);
}

std::string Nd28xEmulator::value_line(double mm) const {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%10.6f", std::abs(inches_ ? mm / kMmPerInch : mm));
  return (std::signbit(mm) ? "-" : "+") + std::string(digits) + " " + marks_ + "\r\n";
}

void Nd28xEmulator::reply(Session session, const std::string& text, TimeNs now) {
  const TimeNs due = clients_.at(session).line.carry(text.size(), baud_, now + latency_);
  timeline_.at(due, [this, session, text](TimeNs at) {
    if (clients_.contains(session)) send(session, text, at);
  });
}

namespace emulator_kind {

extern const EmulatorKind touch_probe;
const EmulatorKind touch_probe{
    .kind = "heidenhain-nd28x",
    .section = "touch_probe",
    .quantity = Quantity::length,
    .switches = Nd28xEmulator::switches,
    .serial_switch = "serial",
    .make = [](Plant& plant, const Switches& switches, PlantPlaces& places,
               TimeNs) -> std::unique_ptr<Emulator> {
      return std::make_unique<Nd28xEmulator>(plant, switches, places.take(Quantity::length));
    }};

}  // namespace emulator_kind

}  // namespace driftwise::simulated
