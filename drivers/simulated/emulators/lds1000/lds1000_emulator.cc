#include "drivers/simulated/emulators/lds1000/lds1000_emulator.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/simulated/emulators/emulator_kind.h"
#include "drivers/simulated/emulators/text.h"

namespace driftwise::simulated {
namespace {

constexpr std::size_t kInputBuffer = 255;
constexpr int kMemory = 2048, kExtendedMemory = 14336;
constexpr double kMicroradPerArcsec = std::numbers::pi / (180.0 * 3600.0) * 1e6;
constexpr char kIdle = 0x40;  // bit 6 of every status character
constexpr int kWrongPower = 1, kWrongPosition = 2, kWaiting = 4, kAcquiring = 8;

// A whole number of up to nine digits; empty: none.
std::optional<int> number_in(const std::string& text) {
  if (text.empty() || text.size() > 9) return std::nullopt;
  return parse_integer(text);
}

std::string error_text(char code) {
  switch (code) {
    case '@':
      return "No error";
    case 'A':
      return "Unknown message code";
    case 'B':
      return "Incorrect axis number";
    case 'C':
      return "Parameter out of limits";
    case 'D':
      return "Unauthorized execution";
    case 'O':
      return "Variable number out of range";
    default:
      return "Communication time-out";
  }
}

}  // namespace

const std::vector<SwitchDescription>& Lds1000Emulator::switches() {
  static const std::vector<SwitchDescription> kAll{
      {"version", "LDS1000 Controller Version 3.10", "M", "what VE says after VE and a blank"},
      {"unit", "urad", "M", "unit of the set-up: urad (as delivered) or sec"},
      {"decimal_comma", "true", "M", "the increment 0.2 of the unit sec is printed 0,2"},
      {"micro_byte", "\\xB5", "U", "the micro sign: one byte, \\xB5 or \\xE6"},
      {"terminator", "\\r\\n", "U", "end of a reply; \\r, \\n or both end a command"},
      {"lost_reading", "last", "U", "TP without a beam: last (good value) or zero"},
      {"stop", "true", "U", "TQ ends an acquisition; false: error A"},
      {"extended_memory", "false", "M", "14336 stored readings instead of 2048"},
      {"integration_ms", "100", "own", "integration constant after power-on"},
      {"sampling_ms", "50", "own", "sampling period after power-on"},
      {"latency_s", "0.01", "own", "from the end of a query to its reply"},
      {"line_gap_s", "0.025", "M", "between the lines of 0TT"},
      {"serial", "false", "own", "also serve a pseudo-terminal (printed in READY): RS-232"},
      {"serial_baud", "9600", "U", "RS-232 replies take 10 bits per byte; 0: no time"},
      {"max_clients", "1", "own", "TCP connections at a time; one more is closed at once"},
  };
  return kAll;
}

Lds1000Emulator::Lds1000Emulator(PlantAngles& plant, const Switches& s, int index)
    : plant_(plant),
      index_(index),
      terminator_(s.escaped_text("terminator")),
      version_(s.text("version")),
      arcsec_(s.choice("unit", {"urad", "sec"}) == "sec"),
      hold_last_(s.choice("lost_reading", {"last", "zero"}) == "last"),
      stop_known_(s.flag("stop")),
      extended_memory_(s.flag("extended_memory")),
      step_(arcsec_ ? 0.02 : 0.1),
      decimals_(arcsec_ ? 2 : 1),
      latency_(nanoseconds_from(s.number("latency_s", 0, 10))),
      line_gap_(nanoseconds_from(s.number("line_gap_s", 0, 10))),
      baud_(s.number("serial_baud", 0, 1e6)),
      sampling_ms_(s.integer("sampling_ms", 1, 100000)),
      integration_ms_(s.integer("integration_ms", 1, 100000)) {
  unit_text_ = arcsec_ ? "sec" : s.escaped_text("micro_byte") + "rad";
  increment_text_ = !arcsec_ ? "1" : s.flag("decimal_comma") ? "0,2" : "0.2";
  if (index < 0 || index >= plant.collimator_count())
    throw SetupError("[emulator.lds1000]: asked for the plant's autocollimator " +
                     std::to_string(index + 1) + ", it has " +
                     std::to_string(plant.collimator_count()));
}

void Lds1000Emulator::open(Session session, Link link, TimeNs) {
  clients_.insert_or_assign(session, Client{TimedLine(link), LineBuffer('\r', kInputBuffer)});
}

void Lds1000Emulator::close(Session session, TimeNs) { clients_.erase(session); }

void Lds1000Emulator::receive(Session session, std::string_view bytes, TimeNs now) {
  const auto found = clients_.find(session);
  if (found == clients_.end()) return;
  for (const char c : bytes) {
    const auto done = found->second.input.push(c == '\n' ? '\r' : c);
    if (!done) continue;
    if (done->overrun)
      error_ = 'A';
    else if (!trim(done->text).empty())
      line(session, trim(done->text), now);
  }
}

void Lds1000Emulator::line(Session session, std::string_view text, TimeNs now) {
  const auto is_upper = [](char c) { return c >= 'A' && c <= 'Z'; };
  std::size_t name = 0;
  while (name < text.size() && is_digit(text[name])) ++name;
  if (name + 2 > text.size() || !is_upper(text[name]) || !is_upper(text[name + 1])) {
    error_ = 'A';
    return;
  }
  const Command command{.prefix = std::string(text.substr(0, name)),
                        .name = std::string(text.substr(name, 2)),
                        .value = std::string(text.substr(name + 2))};
  if (!query(session, command, now)) setter(command, now);
}

bool Lds1000Emulator::query(Session session, const Command& command, TimeNs now) {
  const std::string& name = command.name;
  if (name == "TE") {
    reply(session, std::string("TE") + std::exchange(error_, '@'), now);
  } else if (name == "TB") {
    const char code = std::exchange(error_, '@');
    reply(session, std::string("TB") + code + " " + error_text(code), now);
  } else if (name == "MS") {
    reply(session, std::string("MS") + status(now), now);
  } else if (name == "TS") {
    reply(session, std::string("TS") + static_cast<char>(kIdle | (extended_memory_ ? 1 : 0) | 2),
          now);
  } else if (name == "VE") {
    reply(session, "VE " + version_, now);
  } else if (name == "XI") {
    reply(session, "XI" + std::to_string(integration_ms_), now);
  } else if (name == "XN") {
    reply(session, "XN" + std::to_string(stored_.size()), now);
  } else if (name == "TP" || name == "TA") {
    const auto axis = axis_of(command);
    if (!axis) return true;
    const Stored value = name == "TP" ? measure(now) : Stored{};
    reply(session,
          command.prefix + name +
              (name == "TP" ? shown(*axis == 1 ? value.y : value.z) : set_up(*axis)),
          now);
  } else if (name == "TT") {
    const auto first = number_in(command.prefix);
    if (!first || *first > static_cast<int>(stored_.size()))
      error_ = 'C';
    else
      stored_lines(session, *first, now);
  } else {
    return false;
  }
  return true;
}

void Lds1000Emulator::setter(const Command& command, TimeNs now) {
  const std::string& name = command.name;
  if (name == "SP" || name == "KI") {
    const auto value = number_in(command.value);
    if (!value || *value < 1 || *value > 100000) {
      error_ = 'C';
      return;
    }
    (name == "SP" ? sampling_ms_ : integration_ms_) = *value;
  } else if (name == "TM" || name == "TK") {
    acquire(command, now);
  } else if (name == "TQ" && stop_known_) {
    if (acquisition_) timeline_.cancel(*acquisition_);
    acquisition_.reset();
    wanted_ = 0;
    waiting_for_trigger_ = false;
  } else {
    error_ = 'A';
  }
}

void Lds1000Emulator::acquire(const Command& command, TimeNs now) {
  const auto count = number_in(command.value);
  if (!count || *count < 1 || *count > (extended_memory_ ? kExtendedMemory : kMemory)) {
    error_ = 'C';
    return;
  }
  if (wanted_ > 0) {
    error_ = 'D';
    return;
  }
  stored_.clear();
  wanted_ = *count;
  // Nothing is wired to the trigger input: those readings never come.
  waiting_for_trigger_ = command.name == "TK";
  if (!waiting_for_trigger_) take_reading(now);
}

void Lds1000Emulator::take_reading(TimeNs due) {
  acquisition_.reset();
  stored_.push_back(measure(due));
  if (--wanted_ <= 0) return;
  acquisition_ = timeline_.at(due + sampling_ms_ * (kSecondNs / 1000),
                              [this](TimeNs next) { take_reading(next); });
}

void Lds1000Emulator::stored_lines(Session session, int first, TimeNs now) {
  const auto text = [this](std::size_t k) {
    return std::to_string(k + 1) + "TT,1TP" + shown(stored_[k].y) + ",2TP" + shown(stored_[k].z);
  };
  if (first > 0) {
    reply(session, text(static_cast<std::size_t>(first) - 1), now);
    return;
  }
  for (std::size_t k = 0; k < stored_.size(); ++k)
    reply(session, text(k), now + static_cast<TimeNs>(k) * line_gap_);
}

std::optional<int> Lds1000Emulator::axis_of(const Command& command) {
  const auto axis = number_in(command.prefix);
  if (axis && (*axis == 1 || *axis == 2)) return axis;
  error_ = 'B';
  return std::nullopt;
}

Lds1000Emulator::Stored Lds1000Emulator::measure(TimeNs now) {
  const AngleReading reading = plant_.measure_angle(index_, integration_ms_ * 1e-3, now);
  if (reading.power_wrong || reading.position_wrong) return hold_last_ ? last_good_ : Stored{};
  const double scale = arcsec_ ? 1.0 : kMicroradPerArcsec;
  const auto displayed = [&](double arcsec) { return std::round(arcsec * scale / step_) * step_; };
  last_good_ = {displayed(reading.y_arcsec), displayed(reading.z_arcsec)};
  return last_good_;
}

std::string Lds1000Emulator::shown(double value) const {
  return fixed(value == 0 ? 0.0 : value, decimals_);  // never "-0.0"
}

std::string Lds1000Emulator::set_up(int axis) const {
  return ",RT," + std::string(axis == 1 ? "04512" : "04498") + "," + increment_text_ + "," +
         unit_text_ + ",00102,00241";
}

char Lds1000Emulator::status(TimeNs now) {
  const AngleReading reading = plant_.measure_angle(index_, integration_ms_ * 1e-3, now);
  int bits = kIdle;
  if (reading.power_wrong) bits |= kWrongPower;
  if (reading.position_wrong) bits |= kWrongPosition;
  if (waiting_for_trigger_) bits |= kWaiting;
  if (wanted_ > 0) bits |= kAcquiring;
  return static_cast<char>(bits);
}

void Lds1000Emulator::reply(Session session, std::string text, TimeNs now) {
  text += terminator_;
  const TimeNs due = clients_.at(session).line.carry(text.size(), baud_, now + latency_);
  timeline_.at(due, [this, session, bytes = std::move(text)](TimeNs at) {
    if (clients_.contains(session)) send(session, bytes, at);
  });
}

namespace emulator_kind {

extern const EmulatorKind lds1000;
const EmulatorKind lds1000{.kind = "newport-lds1000",
                           .section = "lds1000",
                           .quantity = Quantity::angle,
                           .switches = Lds1000Emulator::switches,
                           .serial_switch = "serial",
                           .make = [](Plant& plant, const Switches& switches, PlantPlaces& places,
                                      TimeNs) -> std::unique_ptr<Emulator> {
                             return std::make_unique<Lds1000Emulator>(plant, switches,
                                                                      places.take(Quantity::angle));
                           }};

}  // namespace emulator_kind

}  // namespace driftwise::simulated
