#pragma once
// What a Keithley 2700/2701 keeps per scanner channel (and once more for the front inputs): the
// function and its parameters, how long one reading takes with them, and what a resistance becomes
// on the wire.

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/simulated/emulators/keithley_2701/rtd.h"

namespace driftwise::simulated {

enum class Function { volt_dc, volt_ac, curr_dc, curr_ac, res, fres, temp, freq, per, cont };
constexpr std::size_t kFunctionCount = 10;

std::optional<Function> function_from(std::string_view quoted);  // 'FRES', "volt:dc", case-blind
std::string function_text(Function function);                    // "FRES" with its quotes
std::string function_unit(Function function, char temperature_unit);  // OHM4W, C, VDC ..
bool is_four_wire(Function function, bool frtd);

struct FunctionSettings {
  double range = 0;  // 0: automatic
  double nplc = 5;
  bool offset_compensated = false;
  bool filter_on = false;
  int filter_count = 10;
  bool filter_repeats = false;
};

struct ChannelSettings {
  Function function = Function::volt_dc;
  std::array<FunctionSettings, kFunctionCount> per_function{};
  bool frtd = false;  // TEMP:TRAN FRTD, else a thermocouple or thermistor
  std::string frtd_type = "PT100";
  RtdConstants user{100, .00385, .111, 1.507};

  FunctionSettings& of(Function f) { return per_function[static_cast<std::size_t>(f)]; }
  const FunctionSettings& now() const { return per_function[static_cast<std::size_t>(function)]; }
  bool four_wire() const { return is_four_wire(function, frtd); }
  RtdConstants rtd() const { return rtd_constants(frtd_type).value_or(user); }
};

// 100, 1k .. 100M: the smallest that holds the value; nullopt above 120 Mohm or below 0.
std::optional<double> resistance_range(double ohm);

// Without relays and trigger delay: 4 integrations for a compensated ohm (or FRTD) reading, 2
// otherwise, times the repeating filter's count.
double integration_s(const ChannelSettings& channel, double mains_hz);

}  // namespace driftwise::simulated
