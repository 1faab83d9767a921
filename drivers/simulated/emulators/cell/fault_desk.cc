#include "drivers/simulated/emulators/cell/fault_desk.h"

#include <cmath>

#include "drivers/simulated/emulators/text.h"

namespace driftwise::simulated {
namespace {

constexpr std::string_view kHelp =
    "fault drop|mute|garble|slow|disturb|clock <device> [<n> s] | fault break-beam [<device>] | "
    "fault "
    "wrong-power|wrong-position|mend-beam <device> | fault jam|mend-load | fault "
    "open-probe|mend-probe <input> | fault volt <input> <volts>|mend | fault lie <device> "
    "jump|scale|value <x> | fault lie <device> "
    "constant | fault clear [<device>] | fault knock <a> nm | load <newton> | open <n> s | "
    "spacers <h> mm | substrate <rx> <ry> arcsec | microscope? <indent> | pass <n> s | truth? | "
    "time? | help";
constexpr const char* kUnable = "ERR this cell cannot do that";
constexpr double kUsualShock_nm = 60;

std::string wrong(const std::string& what) { return "ERR " + what; }

// The number before the unit: "<n> s" anywhere in the words.
std::optional<double> quantity(const std::vector<std::string_view>& words, std::string_view unit) {
  for (std::size_t i = 1; i < words.size(); ++i)
    if (words[i] == unit) return parse_number(words[i - 1]);
  return std::nullopt;
}

}  // namespace

void FaultDesk::receive(Session session, std::string_view bytes, TimeNs now) {
  const auto found = input_.find(session);
  if (found == input_.end()) return;
  for (const char c : bytes) {
    auto line = found->second.push(c);
    if (!line) continue;
    if (line->text.ends_with('\r')) line->text.pop_back();
    if (line->overrun)
      send(session, "ERR line too long\n", now);
    else if (!trim(line->text).empty())
      send(session, answer(line->text, now) + "\n", now);
  }
}

std::string FaultDesk::answer(std::string_view line, TimeNs now) {
  const auto words = split_blanks(line);
  if (words.empty()) return wrong("empty line");
  if (words[0] == "help") return "OK " + std::string(kHelp);
  if (words[0] == "time?") return "OK " + std::to_string(now);
  if (words[0] == "truth?")
    return hooks_.truth_json ? "OK " + hooks_.truth_json(now) : wrong("this cell cannot do that");
  if (words[0] == "load") return hang(words, now);
  if (words[0] == "spacers") return spacers(words, now);
  if (words[0] == "substrate") return substrate(words, now);
  if (words[0] == "microscope?") return microscope(words);
  if (words[0] == "open") return open_box(words, now);
  if (words[0] == "pass") return pass(words);
  if (words[0] == "fault" && words.size() >= 2) return fault(words, now);
  return wrong("found '" + std::string(line.substr(0, 80)) + "', expected " + std::string(kHelp));
}

std::string FaultDesk::knock(const std::vector<std::string_view>& words, TimeNs now) {
  const auto amplitude_nm = quantity(words, "nm");
  if (!amplitude_nm) return wrong("expected fault knock <a> nm, such as fault knock 400 nm");
  if (!hooks_.knock) return kUnable;
  hooks_.knock(*amplitude_nm, now);
  return "OK";
}

std::string FaultDesk::spacers(const std::vector<std::string_view>& words, TimeNs now) {
  const auto height_mm = quantity(words, "mm");
  if (!height_mm) return wrong("expected spacers <h> mm, such as spacers 14 mm");
  if (!hooks_.spacers) return kUnable;
  return hooks_.spacers(*height_mm, now) ? "OK" : wrong("expected a height of 0 to 100 mm");
}

std::string FaultDesk::substrate(const std::vector<std::string_view>& words, TimeNs now) {
  const bool form = words.size() == 4 && words[3] == "arcsec";
  const auto rx_arcsec = form ? parse_number(words[1]) : std::nullopt;
  const auto ry_arcsec = form ? parse_number(words[2]) : std::nullopt;
  if (!rx_arcsec || !ry_arcsec)
    return wrong("expected substrate <rx> <ry> arcsec, such as substrate 540 1296 arcsec");
  if (!hooks_.substrate) return kUnable;
  return hooks_.substrate(*rx_arcsec, *ry_arcsec, now) ? "OK"
                                                       : wrong("expected tilts of -3600 to 3600");
}

std::string FaultDesk::microscope(const std::vector<std::string_view>& words) {
  const auto origin = words.size() == 2 ? parse_integer(words[1]) : std::nullopt;
  if (!origin) return wrong("expected microscope? <indent>, such as microscope? 1");
  if (!hooks_.microscope_json) return kUnable;
  const std::string json = hooks_.microscope_json(static_cast<int>(*origin));
  return json.empty() ? wrong("there is no such indent") : "OK " + json;
}

std::string FaultDesk::hang(const std::vector<std::string_view>& words, TimeNs now) {
  const auto newton = words.size() == 2 ? parse_number(words[1]) : std::nullopt;
  if (!newton) return wrong("expected load <newton>, such as load 2.305");
  if (!hooks_.hang) return kUnable;
  return hooks_.hang(*newton, now) ? "OK" : wrong("there are not so many weights");
}

std::string FaultDesk::open_box(const std::vector<std::string_view>& words, TimeNs now) {
  constexpr double kDay_s = 86400;
  const auto seconds = quantity(words, "s");
  if (!seconds || !(*seconds >= 0 && *seconds <= kDay_s))
    return wrong("expected open <n> s, such as open 1800 s");
  if (!hooks_.open_box) return kUnable;
  return hooks_.open_box(*seconds, now) ? "OK" : wrong("this cell has no box");
}

std::string FaultDesk::pass(const std::vector<std::string_view>& words) {
  constexpr double kWeek_s = 7 * 86400;
  const auto seconds = words.size() == 3 ? quantity(words, "s") : std::nullopt;
  if (!seconds || !(*seconds >= 0 && *seconds <= kWeek_s))
    return wrong("expected pass <n> s of at most a week, such as pass 32400 s");
  if (!hooks_.pass) return kUnable;
  const std::string refusal = hooks_.pass(*seconds);
  return refusal.empty() ? "OK" : wrong(refusal);
}

std::string FaultDesk::lie(const std::vector<std::string_view>& words) {
  const bool constant = words.size() == 4 && words[3] == "constant";
  const bool sized =
      words.size() == 5 && (words[3] == "jump" || words[3] == "scale" || words[3] == "value");
  const auto amount = sized ? parse_number(words[4]) : std::optional(0.0);
  if ((!constant && !sized) || !amount)
    return wrong("expected fault lie <device> jump|scale|value <x>, or constant");
  if (!hooks_.lie) return kUnable;
  const std::string device(words[2]);
  return hooks_.lie(device, std::string(words[3]), *amount) ? "OK"
                                                            : wrong("no device '" + device + "'");
}

std::string FaultDesk::volt(const std::vector<std::string_view>& words, TimeNs now) {
  const auto input = words.size() == 4 ? parse_integer(words[2]) : std::nullopt;
  const bool mends = words.size() == 4 && words[3] == "mend";
  const auto volts = input && !mends ? parse_number(words[3]) : std::nullopt;
  if (!input || (!mends && !volts))
    return wrong("expected fault volt <input> <volts>, such as fault volt 201 9.5, or mend");
  if (!hooks_.input_volt) return kUnable;
  return hooks_.input_volt(static_cast<int>(*input), volts, now)
             ? "OK"
             : wrong("no sensor with a voltage on this input");
}

std::optional<std::string> FaultDesk::world_fault(const std::vector<std::string_view>& words,
                                                  TimeNs now) {
  using Spot = FaultHooks::Spot;
  const std::string_view verb = words[1];
  const std::string device(words.size() >= 3 ? words[2] : "");
  if (verb == "break-beam") {
    if (!hooks_.break_beam) return kUnable;
    return hooks_.break_beam(device, now) ? "OK" : wrong("'" + device + "' is no interferometer");
  }
  if (verb == "wrong-power" || verb == "wrong-position" || verb == "mend-beam") {
    if (!hooks_.set_spot) return kUnable;
    const Spot spot = verb == "wrong-power"      ? Spot::wrong_power
                      : verb == "wrong-position" ? Spot::wrong_position
                                                 : Spot::good;
    return hooks_.set_spot(device, spot, now) ? "OK"
                                              : wrong("'" + device + "' is no autocollimator");
  }
  if (verb == "jam" || verb == "mend-load") {
    if (!hooks_.set_jammed) return kUnable;
    hooks_.set_jammed(verb == "jam", now);
    return "OK";
  }
  return std::nullopt;
}

std::string FaultDesk::fault(const std::vector<std::string_view>& words, TimeNs now) {
  const std::string_view verb = words[1];
  const std::string unable = kUnable;
  if (auto done = world_fault(words, now)) return *done;
  if (verb == "lie") return lie(words);
  if (verb == "knock") return knock(words, now);
  if (verb == "volt") return volt(words, now);
  if (verb == "clear" && hooks_.lie) hooks_.lie("", "", 0);
  if (verb == "open-probe" || verb == "mend-probe") {
    const auto input = words.size() == 3 ? parse_integer(words[2]) : std::nullopt;
    if (!input) return wrong("expected fault " + std::string(verb) + " <input>, such as 103");
    if (!hooks_.open_probe) return unable;
    return hooks_.open_probe(*input, verb == "open-probe", now) ? "OK"
                                                                : wrong("no probe on this input");
  }
  if (verb == "clear" && words.size() == 2) {
    for (std::size_t i = 0; i < bench_.size(); ++i) bench_.faults(i) = Faults{};
    return "OK";
  }
  const auto device = words.size() >= 3 ? bench_.find(std::string(words[2])) : std::nullopt;
  if (!device) {
    std::string ids;
    for (std::size_t i = 0; i < bench_.size(); ++i) ids += " " + bench_.id(i);
    return wrong("expected fault " + std::string(verb) + " <device>, one of" + ids);
  }
  Faults& faults = bench_.faults(*device);
  const auto seconds = quantity(words, "s");
  if (verb == "clock") {
    if (!seconds || !(std::abs(*seconds) <= 1e9))
      return wrong("expected fault clock <device> <n> s");
    return bench_.set_clock(*device, nanoseconds_from(*seconds)) ? "OK" : wrong("it has no clock");
  }
  if (seconds && (*seconds < 0 || *seconds > 1e7)) return wrong("seconds out of range");
  const TimeNs span = nanoseconds_from(seconds.value_or(0));
  if (verb == "drop") {
    if (!hooks_.drop) return unable;
    hooks_.drop(*device, seconds.value_or(0));
  } else if (verb == "garble") {
    if (seconds)
      faults.garble_until = now + span;
    else
      faults.garble_next = 1;
  } else if (verb == "clear") {
    faults = Faults{};
  } else if (!seconds) {
    return wrong("expected fault " + std::string(verb) + " <device> <n> s");
  } else if (verb == "mute") {
    faults.mute_until = now + span;
  } else if (verb == "slow") {
    faults.slow_ns = span;
  } else if (verb == "disturb") {
    if (!hooks_.disturb) return unable;
    hooks_.disturb(now, now + span, quantity(words, "nm").value_or(kUsualShock_nm));
  } else {
    return wrong("no fault '" + std::string(verb) + "'; there are " + std::string(kHelp));
  }
  return "OK";
}

}  // namespace driftwise::simulated
