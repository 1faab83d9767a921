#include "drivers/simulated/emulators/pi_gcs/pi_gcs_emulator.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

#include "drivers/simulated/emulators/emulator_kind.h"
#include "drivers/simulated/emulators/text.h"

namespace driftwise::simulated {
namespace {

constexpr std::size_t kGcsLineLimit = 1024;

std::string hex_text(unsigned value) {
  char buffer[16];
  std::snprintf(buffer, sizeof buffer, "%X", value);
  return buffer;
}

// Two simulated cells are two machines, and so are two controllers of one: each has its number.
std::string with_serial_number(std::string identity, int first_axis) {
  constexpr int kFirst = 115000000, kPerAxis = 5000000;  // process ids are below 4194304
  if (const auto at = identity.find("%S"); at != std::string::npos)
    identity.replace(at, 2, std::to_string(kFirst + kPerAxis * first_axis + getpid()));
  return identity;
}

}  // namespace

const std::vector<SwitchDescription>& PiGcsEmulator::switches() {
  static const std::vector<SwitchDescription> kAll{
      {"axes", "X", "D", "axis names in the plant's order, separated by commas"},
      {"identity", "(c)2015 Physik Instrumente (PI) GmbH & Co. KG, C-887, %S, 2.1.0.3", "D",
       "answer to *IDN?; %S is the serial number, another one for each simulated cell"},
      {"start_delay_s", "0.2", "U", "from an accepted MOV to the start of the motion"},
      {"stale_on_target", "true", "U",
       "until the motion starts ONT? still answers for the previous target; false: 0 at once"},
      {"moving_before_start", "false", "U",
       "the 0x05 mask is set as soon as MOV is accepted; false: when the motion starts"},
      {"latency_s", "0.002", "own", "from the end of a request to its reply"},
      {"decimals", "7", "D", "decimals of positions"},
      {"ready_byte", "\\xB1", "U", "answer to 0x07 when ready"},
      {"busy_byte", "\\xB0", "U", "answer to 0x07 while referencing"},
      {"ready_line_feed", "true", "U", "LF after the answer to 0x07"},
      {"status_prefix", "0x", "U", "before the hex digits of the 0x04 status word"},
      {"ini", "true", "U", "INI references (older models); false: error 2"},
      {"limits", "true", "U", "TMN? and TMX? exist; false: error 2 and no line"},
      {"vls", "true", "U", "VLS, VLS? (velocity of all axes) exist"},
      {"vel", "true", "U", "VEL, VEL? (velocity per axis) exist"},
      {"vmo_reply", "number", "U", "VMO? answers one number or a line per axis"},
      {"error_keep", "last", "U", "which of several errors ERR? reports: last or first"},
      {"max_velocity_mm_s", "20", "own", "above it VEL and VLS give error 8"},
      {"velocity_mm_s", "1", "own", "velocity after power-on"},
      {"servo_on", "false", "U", "servo state after power-on"},
      {"max_clients", "4", "U", "TCP connections at a time; one more is closed at once"},
  };
  return kAll;
}

PiGcsEmulator::PiGcsEmulator(PlantAxes& plant, int first_axis, const Switches& s, TimeNs power_on)
    : plant_(plant),
      first_axis_(first_axis),
      names_(s.words("axes")),
      identity_(with_serial_number(s.text("identity"), first_axis)),
      status_prefix_(s.text("status_prefix")),
      ready_(s.escaped_text("ready_byte")),
      busy_(s.escaped_text("busy_byte")),
      stale_on_target_(s.flag("stale_on_target")),
      keep_first_error_(s.choice("error_keep", {"last", "first"}) == "first"),
      ini_known_(s.flag("ini")),
      limits_known_(s.flag("limits")),
      vls_known_(s.flag("vls")),
      vel_known_(s.flag("vel")),
      vmo_single_(s.choice("vmo_reply", {"number", "axes"}) == "number"),
      mask_follows_start_(!s.flag("moving_before_start")),
      decimals_(s.integer("decimals", 1, 12)),
      start_delay_(nanoseconds_from(s.number("start_delay_s", 0, 10))),
      latency_(nanoseconds_from(s.number("latency_s", 0, 10))),
      max_velocity_(s.number("max_velocity_mm_s", 1e-6, 1e6)) {
  if (names_.empty() || first_axis_ + axis_count() > plant.axis_count())
    throw SetupError("[emulator.pi] axes: found " + std::to_string(names_.size()) +
                     " names, the plant has " + std::to_string(plant.axis_count()) + " axes, " +
                     std::to_string(first_axis_) + " of them at the controllers before");
  if (s.flag("ready_line_feed")) ready_ += '\n', busy_ += '\n';
  target_mm_.assign(names_.size(), 0.0);
  velocity_mm_s_.assign(names_.size(), s.number("velocity_mm_s", 1e-6, max_velocity_));
  servo_.assign(names_.size(), s.flag("servo_on"));
  for (int axis = 0; axis < axis_count(); ++axis) {
    names_[static_cast<std::size_t>(axis)] = upper(names_[static_cast<std::size_t>(axis)]);
    plant.set_servo(first_axis_ + axis, servo_.front(), power_on);
    plant.set_velocity(first_axis_ + axis, velocity_mm_s_.front(), power_on);
  }
}

void PiGcsEmulator::open(Session session, Link, TimeNs) {
  input_.insert_or_assign(session, LineBuffer('\n', kGcsLineLimit));
}

void PiGcsEmulator::close(Session session, TimeNs) { input_.erase(session); }

void PiGcsEmulator::receive(Session session, std::string_view bytes, TimeNs now) {
  const auto found = input_.find(session);
  if (found == input_.end()) return;
  for (const char c : bytes) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte == 0x03 || byte == 0x04 || byte == 0x05 || byte == 0x07 || byte == 0x18) {
      single_byte(session, byte, now);
    } else if (const auto done = found->second.push(c)) {
      line(session, *done, now);
    }
  }
}

void PiGcsEmulator::single_byte(Session session, unsigned char byte, TimeNs now) {
  switch (byte) {
    case 0x03:
      reply_per_axis(session, {}, now,
                     [&](int axis) { return fixed(axis_state(axis, now).q_mm, decimals_); });
      break;
    case 0x04:
      reply(session, status_prefix_ + hex_text(all_referenced(now) ? 0x10000u : 0u) + "\n", now);
      break;
    case 0x05: {
      unsigned mask = 0;
      for (int axis = 0; axis < axis_count(); ++axis) {
        const AxisState state = axis_state(axis, now);
        const bool waiting =
            pending_ && std::any_of(pending_->targets.begin(), pending_->targets.end(),
                                    [axis](const Pair& pair) { return pair.axis == axis; });
        if (state.moving || state.referencing || (waiting && !mask_follows_start_))
          mask |= 1u << axis;
      }
      reply(session, hex_text(mask) + "\n", now);
      break;
    }
    case 0x07:
      reply(session, any_referencing(now) ? busy_ : ready_, now);
      break;
    default:
      halt(now);
  }
}

void PiGcsEmulator::line(Session session, const LineBuffer::Line& line, TimeNs now) {
  std::string_view text = line.text;
  if (text.ends_with('\r')) text.remove_suffix(1);
  const auto words = split_blanks(text);
  if (line.overrun) {
    error(1);
    return;
  }
  if (words.empty()) return;
  const bool printable =
      std::all_of(text.begin(), text.end(), [](char c) { return c >= ' ' && c <= '~'; });
  const std::string name = upper(words[0]);
  const bool command = name[0] == '*' || is_letter(name[0]);
  if (!printable || !command) {
    error(1);
    return;
  }
  const Words rest(words.data() + 1, words.size() - 1);
  if (name.ends_with('?'))
    query(session, name, rest, now);
  else
    setter(name, rest, now);
}

void PiGcsEmulator::query(Session session, const std::string& name, Words words, TimeNs now) {
  const auto state = [&](int axis) { return axis_state(axis, now); };
  const auto number = [&](double value) { return fixed(value, decimals_); };
  const auto bit = [](bool on) { return std::string(on ? "1" : "0"); };
  const auto at = [](auto& list, int axis) { return list[static_cast<std::size_t>(axis)]; };
  if (name == "ERR?") {
    reply(session, std::to_string(std::exchange(error_, 0)) + "\n", now);
  } else if (name == "*IDN?") {
    reply(session, identity_ + "\n", now);
  } else if (name == "POS?") {
    reply_per_axis(session, words, now, [&](int axis) { return number(state(axis).q_mm); });
  } else if (name == "MOV?") {
    reply_per_axis(session, words, now, [&](int axis) { return number(at(target_mm_, axis)); });
  } else if (name == "SVO?") {
    reply_per_axis(session, words, now, [&](int axis) { return bit(at(servo_, axis)); });
  } else if (name == "FRF?") {
    reply_per_axis(session, words, now, [&](int axis) { return bit(state(axis).referenced); });
  } else if (name == "ONT?") {
    reply_per_axis(session, words, now, [&](int axis) {
      return bit(state(axis).on_target && (!pending_ || stale_on_target_));
    });
  } else if (name == "TMN?" && limits_known_) {
    reply_per_axis(session, words, now, [&](int axis) { return number(axis_travel(axis).min_mm); });
  } else if (name == "TMX?" && limits_known_) {
    reply_per_axis(session, words, now, [&](int axis) { return number(axis_travel(axis).max_mm); });
  } else if (name == "VEL?" && vel_known_) {
    reply_per_axis(session, words, now, [&](int axis) { return number(at(velocity_mm_s_, axis)); });
  } else if (name == "VLS?" && vls_known_) {
    reply(session, number(velocity_mm_s_.front()) + "\n", now);
  } else if (name == "CSV?") {
    reply(session, "2.0\n", now);
  } else if (name == "SAI?") {
    std::string text;
    for (const auto& axis : names_) text += (text.empty() ? "" : " \n") + axis;
    reply(session, text + "\n", now);
  } else if (name == "VMO?") {
    const auto wanted = pairs(words);
    if (!wanted) return;
    bool all = true;
    std::string lines;
    for (const auto& [axis, mm] : *wanted) {
      const AxisTravel travel = axis_travel(axis);
      const bool inside = mm >= travel.min_mm && mm <= travel.max_mm;
      all = all && inside;
      lines += (lines.empty() ? "" : " \n") + at(names_, axis) + "=" + bit(inside);
    }
    reply(session, (vmo_single_ ? bit(all) : lines) + "\n", now);
  } else {
    error(2);
  }
}

void PiGcsEmulator::setter(const std::string& name, Words words, TimeNs now) {
  if (name == "MOV") {
    move(words, false, now);
  } else if (name == "MVR") {
    move(words, true, now);
  } else if (name == "SVO") {
    set_servo(words, now);
  } else if (name == "FRF" || (name == "INI" && ini_known_)) {
    reference(words, now);
  } else if (name == "VEL" && vel_known_) {
    set_velocity(words, false, now);
  } else if (name == "VLS" && vls_known_) {
    set_velocity(words, true, now);
  } else if (name == "HLT") {
    if (axes(words)) halt(now);
  } else if (name == "STP") {
    if (!words.empty())
      error(24);
    else
      halt(now);
  } else {
    error(2);
  }
}

namespace emulator_kind {

extern const EmulatorKind pi_gcs;
const EmulatorKind pi_gcs{.kind = "pi-gcs",
                          .section = "pi",
                          .quantity = Quantity::axis,
                          .switches = PiGcsEmulator::switches,
                          .serial_switch = "",
                          .make = [](Plant& plant, const Switches& switches, PlantPlaces& places,
                                     TimeNs now) -> std::unique_ptr<Emulator> {
                            const auto axes = switches.words("axes").size();
                            const int first = places.take(Quantity::axis, static_cast<int>(axes));
                            return std::make_unique<PiGcsEmulator>(plant, first, switches, now);
                          }};

}  // namespace emulator_kind

}  // namespace driftwise::simulated
