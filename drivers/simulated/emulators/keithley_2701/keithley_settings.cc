#include "drivers/simulated/emulators/keithley_2701/keithley_settings.h"

#include "drivers/simulated/emulators/text.h"

namespace driftwise::simulated {
namespace {

struct Name {
  Function function;
  std::string_view reply;  // what FUNC? says
  std::vector<std::string_view> accepted;
};

const std::vector<Name>& names() {
  static const std::vector<Name> kNames{
      {Function::volt_dc, "VOLT", {"VOLT", "VOLTAGE", "VOLT:DC", "VOLTAGE:DC"}},
      {Function::volt_ac, "VOLT:AC", {"VOLT:AC", "VOLTAGE:AC"}},
      {Function::curr_dc, "CURR", {"CURR", "CURRENT", "CURR:DC", "CURRENT:DC"}},
      {Function::curr_ac, "CURR:AC", {"CURR:AC", "CURRENT:AC"}},
      {Function::res, "RES", {"RES", "RESISTANCE"}},
      {Function::fres, "FRES", {"FRES", "FRESISTANCE"}},
      {Function::temp, "TEMP", {"TEMP", "TEMPERATURE"}},
      {Function::freq, "FREQ", {"FREQ", "FREQUENCY"}},
      {Function::per, "PER", {"PER", "PERIOD"}},
      {Function::cont, "CONT", {"CONT", "CONTINUITY"}},
  };
  return kNames;
}

}  // namespace

std::optional<Function> function_from(std::string_view quoted) {
  if (quoted.size() < 2 || (quoted.front() != '\'' && quoted.front() != '"') ||
      quoted.back() != quoted.front())
    return std::nullopt;
  const std::string wanted = upper(trim(quoted.substr(1, quoted.size() - 2)));
  for (const auto& name : names())
    for (const auto& accepted : name.accepted)
      if (wanted == accepted) return name.function;
  return std::nullopt;
}

std::string function_text(Function function) {
  for (const auto& name : names())
    if (name.function == function) return "\"" + std::string(name.reply) + "\"";
  return "\"\"";
}

std::string function_unit(Function function, char temperature_unit) {
  switch (function) {
    case Function::volt_dc:
      return "VDC";
    case Function::volt_ac:
      return "VAC";
    case Function::curr_dc:
      return "ADC";
    case Function::curr_ac:
      return "AAC";
    case Function::res:
    case Function::cont:
      return "OHM";
    case Function::fres:
      return "OHM4W";
    case Function::temp:
      return std::string(1, temperature_unit);
    case Function::freq:
      return "HZ";
    case Function::per:
      return "SECS";
  }
  return {};
}

bool is_four_wire(Function function, bool frtd) {
  return function == Function::fres || (function == Function::temp && frtd);
}

std::optional<double> resistance_range(double ohm) {
  if (!(ohm >= 0)) return std::nullopt;
  for (double range = 100; range <= 100e6; range *= 10)
    if (ohm <= 1.2 * range) return range;
  return std::nullopt;
}

double integration_s(const ChannelSettings& channel, double mains_hz) {
  const FunctionSettings& settings = channel.now();
  const bool compensated = (channel.function == Function::fres && settings.offset_compensated) ||
                           (channel.function == Function::temp && channel.frtd);
  const double once = (compensated ? 4 : 2) * settings.nplc / mains_hz;
  return settings.filter_on && settings.filter_repeats ? once * settings.filter_count : once;
}

}  // namespace driftwise::simulated
