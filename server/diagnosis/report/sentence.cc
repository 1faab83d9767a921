#include "server/diagnosis/report/sentence.h"

#include <algorithm>
#include <array>
#include <map>
#include <set>

#include "server/core/channel.h"
#include "server/core/text/quantity_text.h"
#include "server/effects/direct_symbols.h"
#include "server/effects/term_order.h"

namespace driftwise::diagnosis {
namespace {

std::string three_digits(double value) { return digits_text(value); }

// Units of rates as they are written, in the order in which a name is asked for them: the longer
// ones first, for a name may go on ("nm_per_k_x").
struct RateUnit {
  std::string_view name, written;
};
constexpr std::array kRateUnits = {RateUnit{"nm_per_k_per_h", "nm/(K/h)"},
                                   RateUnit{"nm_per_n_per_mm", "nm/(N mm)"},
                                   RateUnit{"nm_per_mm", "nm/mm"},
                                   RateUnit{"nm_per_k", "nm/K"},
                                   RateUnit{"nm_per_n", "nm/N"},
                                   RateUnit{"nm_per_hpa", "nm/hPa"},
                                   RateUnit{"nm_per_h", "nm/h"},
                                   RateUnit{"nm_per_pct", "nm/%"},
                                   RateUnit{"ppm_per_k", "ppm/K"},
                                   RateUnit{"ppm_per_hpa", "ppm/hPa"},
                                   RateUnit{"ppm_per_h", "ppm/h"},
                                   RateUnit{"ppm_per_pct", "ppm/%"},
                                   RateUnit{"arcsec_per_k_per_h", "arcsec/(K/h)"},
                                   RateUnit{"arcsec_per_k", "arcsec/K"},
                                   RateUnit{"arcsec_per_n", "arcsec/N"},
                                   RateUnit{"arcsec_per_h", "arcsec/h"},
                                   RateUnit{"urad_per_newton_m", "urad/(N m)"},
                                   RateUnit{"urad_per_m", "urad/m"}};

// A parameter's name in words: "offset_mm_rx_q1" is the offset rx in mm of q1.
struct ParameterWords {
  std::string label, unit, of;
};

// The unit is a rate, or the last part of the name that is a unit; what stands behind it says of
// which term, and at last of which output, where several show the cause.
ParameterWords words_of(std::string name, const Finding& finding) {
  ParameterWords words;
  for (const auto& output : finding.outputs)
    if (name.ends_with("_" + output.output)) {
      name.resize(name.size() - output.output.size() - 1);
      words.of = " (" + output.output + ")";
      break;
    }
  const auto without = [&name](std::size_t at, std::size_t length) {
    std::string rest = name.substr(0, at) + name.substr(at + length);
    if (rest.starts_with('_')) rest.erase(0, 1);
    if (rest.ends_with('_')) rest.pop_back();
    for (auto twice = rest.find("__"); twice != std::string::npos; twice = rest.find("__"))
      rest.erase(twice, 1);
    std::ranges::replace(rest, '_', ' ');
    return rest;
  };
  words.label = without(0, 0);
  for (const auto& rate : kRateUnits)
    if (const auto at = name.find(rate.name); at != std::string::npos) {
      words.label = without(at, rate.name.size());
      words.unit = rate.written;
      return words;
    }
  for (auto at = name.rfind('_'); at != std::string::npos && at > 0; at = name.rfind('_', at - 1)) {
    const auto end = name.find('_', at + 1);
    const auto unit = name.substr(at + 1, end == std::string::npos ? end : end - at - 1);
    if (std::ranges::find(known_units(), unit) == known_units().end()) continue;
    words.label = without(at + 1, unit.size());
    words.unit = unit;
    return words;
  }
  return words;
}

// Digits that show the ends of an interval as two numbers: three, or more where it is narrow.
int digits_of(const Interval& interval) {
  constexpr int kMost = 8;
  int digits = 3;
  while (digits < kMost && interval.low != interval.high &&
         digits_text(interval.low, digits) == digits_text(interval.high, digits))
    ++digits;
  return digits;
}

// "tau 1830 s (90 %: 1650 to 2010)"
std::string parameter_text(const FoundParameter& parameter, const Finding& finding) {
  if (parameter.name == "count")
    return three_digits(parameter.value) + (parameter.value == 1 ? " row" : " rows");
  const ParameterWords words = words_of(parameter.name, finding);
  const SizeUnit unit = size_unit({parameter.value}, words.unit);
  const int digits = parameter.ci90 ? digits_of(*parameter.ci90) : 3;
  std::string text = words.label + (words.label.empty() ? "" : " ") +
                     digits_text(parameter.value * unit.factor, digits) +
                     (unit.unit.empty() ? "" : " ") + unit.unit + words.of;
  if (parameter.ci90)
    text += " (90 %: " + digits_text(parameter.ci90->low * unit.factor, digits) + " to " +
            digits_text(parameter.ci90->high * unit.factor, digits) + ")";
  if (!parameter.aliases.empty()) text += ", or another that looks the same here (see the note)";
  return text;
}

// The coordinates that its terms read.
std::string axes_of(const Finding& finding) {
  std::set<std::string> axes;
  for (const auto& term : finding.terms)
    for (const auto& symbol : effects::symbols_of(term))
      if (is_pose_symbol(symbol) || is_motor_symbol(symbol)) axes.insert(symbol);
  std::string text;
  for (const auto& axis : axes) text += (text.empty() ? "" : " and ") + axis;
  return text;
}

// A cause that a thermometer, a force or another channel would show fits as well.
bool follows_a_channel_as_well(const Finding& finding) {
  constexpr std::array kOfChannels = {"thermal_", "refractive_", "force_", "activity_"};
  return std::ranges::any_of(finding.indistinguishable_from, [&](const std::string& rival) {
    return std::ranges::any_of(kOfChannels, [&](const char* of) { return rival.starts_with(of); });
  });
}

std::string what(const Finding& finding) {
  std::string of = finding.subject;
  static const std::map<std::string, std::string> words = {
      {"geometry_order", "the geometry needs terms in % that the simulation lacks"},
      {"thermal_offset", "the robot moves with %, which the simulation does not use"},
      {"thermal_lag", "the robot follows % with a delay"},
      {"thermal_rate", "the robot's error goes with how fast % changes"},
      {"thermal_expansion", "the error grows with position times %"},
      {"self_heating", "the motion of % heats the robot where no sensor sees it"},
      {"activity_heating", "% heats the robot, with a delay"},
      {"force_compliance", "the robot gives way in proportion to the force"},
      {"force_nonlinearity", "the robot gives way to the force, and not in proportion"},
      {"force_position_coupling", "how far the robot gives way depends on where it is"},
      {"backlash", "% has play: it depends on the side it came from"},
      {"backlash joint", "% has play: gravity's torque chooses the flank"},
      {"backlash joint by motion",
       "% has play: it depends on the side it came from, which no robot file says; reach its "
       "targets from one side"},
      {"joint_compliance", "% sags under gravity"},
      {"gear_error", "% turns unevenly: an eccentric wheel or encoder"},
      {"joint_offset_drift", "the zero of % moves with the temperature"},
      {"creep", "the robot creeps after a move of %"},
      {"cyclic_error", "a periodic error along %"},
      {"abbe_offset", "the beam misses the centre of rotation: the error goes with the tilts"},
      {"cosine_error", "the length of % shrinks with the tilt of its mirror"},
      {"refractive_index", "the air on the beam's way changes the length"},
      {"instrument_drift", "the zero drifts steadily"},
      {"step_change", "what is read of % jumps at one instant"},
      {"periodic_disturbance", "something periodic in time that no channel shows"},
      {"outliers", "isolated wrong rows, left out"},
      {"noise_change", "the spread changes, not the mean"},
      {"probe_hysteresis",
       "% is read on one of two sides, and no channel tells on which: dry friction or play in the "
       "instrument that reads it"},
      {"probe_hysteresis by motion",
       "what reads % lags behind its motion: dry friction or play in the instrument"}};
  std::string about = finding.cause;
  if (about == "backlash" && of.starts_with("joint")) about += " joint";
  for (const auto& parameter : finding.parameters)
    if (parameter.name == "width_by_motion_arcsec") about += " by motion";
  if (about == "probe_hysteresis" && !finding.terms.empty()) about += " by motion";
  const auto found = words.find(about);
  std::string text = found == words.end() ? finding.cause + " of %" : found->second;
  if (finding.cause == "instrument_drift" && !finding.terms.empty() &&
      finding.terms.back().factors.size() > 1)
    text = "the scale of % drifts steadily";
  if (finding.cause == "instrument_drift" && !follows_a_channel_as_well(finding))
    text += " and nothing sensed explains it";
  if (of.empty()) of = axes_of(finding);
  if (const auto at = text.find('%'); at != std::string::npos) text.replace(at, 1, of);
  return text;
}

}  // namespace

std::string size_text(double value, const std::string& unit) {
  return three_digits(value) + " " + unit;
}

std::string sentence(const FaultySensor& sensor, const std::string& first_row) {
  const auto count = std::to_string(sensor.rows.size());
  const auto from = first_row + " on";
  switch (sensor.fault) {
    case SensorFault::frozen:
      return "Sensor " + sensor.channel + " gives one and the same value in " + count +
             " rows from " + from + ": it is frozen, and those values are left out.";
    case SensorFault::spiked:
      return "Sensor " + sensor.channel + " gives " + count +
             (sensor.rows.size() == 1 ? " value far off its neighbours: it is left out."
                                      : " values far off their neighbours: they are left out.");
    case SensorFault::jumped:
      return "Sensor " + sensor.channel + " jumps by " + three_digits(sensor.size) + " K from " +
             from +
             (sensor.is_followed ? ", and the outputs follow at once or slowly: the part really "
                                   "changed; the readings are left as they are."
              : !sensor.named ? ", and others change there a little or there is none: the room may "
                                "have done it, or the sensor; the readings are left as they are."
              : sensor.others_change ? ", by more than others change there foretells: the jump is "
                                       "taken out."
              : sensor.mended        ? " and no other does: the jump is taken out."
                              : " and no other does: no part warms so; the readings are left as "
                                "they are, for the outputs do not say.");
    case SensorFault::swapped:
      return "Sensors " + sensor.channel + " and " + sensor.other + " change places from " + from +
             ": they are put back.";
  }
  return "";
}

std::string sentence(const Finding& finding) {
  std::string text = what(finding);
  if (finding.subject.empty() || !text.starts_with(finding.subject))  // q1 is no Q1
    text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  for (const auto& parameter : finding.parameters)
    text += ", " + parameter_text(parameter, finding);
  for (const auto& output : finding.outputs) {
    if (!output.shown || !output.a90_before) continue;
    const SizeUnit unit =
        size_unit({output.amplitude, *output.a90_before, *output.a90_after}, output.unit);
    text += "; " + output.output + ": " + digits_text(output.amplitude * unit.factor) + " " +
            unit.unit + " rms, held-out A90 " + digits_text(*output.a90_before * unit.factor) +
            " -> " + digits_text(*output.a90_after * unit.factor) + " " + unit.unit;
  }
  text += ".";
  if (correction_is_uncertain(finding)) {
    text += " The correction that would follow is not known well enough to be made:";
    for (const auto& output : finding.outputs)
      if (output.correction_u90)
        text += " +-" + size_text(*output.correction_u90, output.unit) + " in " + output.output +
                (&output == &finding.outputs.back() ? "." : ",");
  }
  if (!finding.indistinguishable_from.empty()) {
    text += " These data cannot tell it from ";
    for (std::size_t i = 0; i < finding.indistinguishable_from.size(); ++i)
      text += (i == 0 ? "" : ", ") + finding.indistinguishable_from[i];
    text += ".";
  }
  return text;
}

std::string aliases_note(const Finding& finding) {
  for (const auto& parameter : finding.parameters) {
    if (parameter.aliases.empty()) continue;
    const ParameterWords words = words_of(parameter.name, finding);
    std::string text = finding.cause + (finding.subject.empty() ? "" : " " + finding.subject) +
                       ": where these data were taken the " + words.label + " " +
                       quantity_text(parameter.value, words.unit, 4) + " looks the same as ";
    for (std::size_t i = 0; i < parameter.aliases.size(); ++i)
      text += (i == 0 ? "" : ", ") + quantity_text(parameter.aliases[i], words.unit, 4);
    return text + "; a scan between the positions tells them apart";
  }
  return "";
}

std::string follows_an_output_note(const Finding& finding,
                                   const std::vector<std::string>& outputs) {
  for (const auto& term : finding.terms)
    for (const auto& symbol : effects::symbols_read_at_once(term))
      if (std::ranges::find(outputs, symbol) != outputs.end())
        return effects::notation(term) + " follows " + symbol +
               ", which stands on the left of the formula: a fit does not take it. " +
               (is_motor_symbol(symbol)
                    ? "Correct the scale of that motor in its controller, measure and diagnose "
                      "again"
                    : "Correct the readings of " + symbol + ", and diagnose again");
  return "";
}

}  // namespace driftwise::diagnosis
