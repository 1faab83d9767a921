// SENSe and UNIT: what is measured and how, per channel.

#include <algorithm>

#include "drivers/simulated/emulators/keithley_2701/keithley_emulator.h"
#include "drivers/simulated/emulators/text.h"

namespace driftwise::simulated {
namespace {

std::optional<bool> flag_from(const std::string& text) {
  const std::string word = upper(text);
  if (word == "ON" || word == "1") return true;
  if (word == "OFF" || word == "0") return false;
  return std::nullopt;
}

// "1,1,0": one item per target.
template <class Targets, class Item>
ScpiAnswer list_of(const Targets& targets, Item item) {
  std::string text;
  for (auto* settings : targets.settings) text += (text.empty() ? "" : ",") + item(*settings);
  return scpi_text(std::move(text));
}

}  // namespace

KeithleyEmulator::Targets KeithleyEmulator::targets(Arguments& arguments) {
  if (arguments.empty() || !arguments.back().starts_with("(")) return {{&front_}, {}, 0};
  const auto list = parse_channel_list(arguments.back(), cards_);
  arguments.pop_back();
  if (list.error == 0 && list.channels.empty()) return {{}, {}, -222};
  Targets out{{}, list.channels, list.error};
  for (const int channel : list.channels) out.settings.push_back(&settings_of(channel));
  return out;
}

ChannelSettings& KeithleyEmulator::settings_of(int channel) { return channels_[channel]; }

int KeithleyEmulator::conflict(const Targets& targets, std::optional<Function> function) const {
  if (!needs_function_ || !function || targets.channels.empty()) return 0;
  const bool fits = std::all_of(targets.settings.begin(), targets.settings.end(),
                                [&](const auto* one) { return one->function == *function; });
  return fits ? 0 : -221;
}

// A four-wire channel takes its partner out of the scan, silently; nothing puts it back.
void KeithleyEmulator::shrink_scan() {
  std::erase_if(scan_list_, [this](int channel) {
    return std::any_of(channels_.begin(), channels_.end(), [&](const auto& one) {
      return one.second.four_wire() && cards_.partner(one.first) == channel;
    });
  });
}

template <class Get, class Put>
void KeithleyEmulator::add_number(const std::string& header, std::optional<Function> function,
                                  double min, double max, double fallback, Get get, Put put) {
  tree_.add(
      header,
      [=, this](Arguments arguments) {
        const Targets where = targets(arguments);
        if (where.error != 0) return scpi_error(where.error);
        if (arguments.empty()) return scpi_error(-109);
        if (arguments.size() > 1) return scpi_error(-108);
        const std::string word = upper(arguments[0]);
        auto value = parse_number(word);
        if (word == "DEF" || word == "DEFAULT") value = fallback;
        if (word == "MIN" || word == "MINIMUM") value = min;
        if (word == "MAX" || word == "MAXIMUM") value = max;
        if (!value) return scpi_error(is_letter(word.empty() ? '0' : word[0]) ? -224 : -104);
        if (*value < min || *value > max) return scpi_error(-222);
        if (const int code = conflict(where, function)) return scpi_error(code);
        for (auto* settings : where.settings)
          if (const int code = put(*settings, *value)) return scpi_error(code);
        return scpi_done();
      },
      [=, this](Arguments arguments) {
        const Targets where = targets(arguments);
        if (where.error != 0) return scpi_error(where.error);
        if (!arguments.empty()) return scpi_error(-108);
        return list_of(where, [&](ChannelSettings& one) { return scientific(get(one)); });
      });
}

template <class Get, class Put>
void KeithleyEmulator::add_flag(const std::string& header, std::optional<Function> function,
                                Get get, Put put) {
  tree_.add(
      header,
      [=, this](Arguments arguments) {
        const Targets where = targets(arguments);
        if (where.error != 0) return scpi_error(where.error);
        if (arguments.size() != 1) return scpi_error(arguments.empty() ? -109 : -108);
        const auto on = flag_from(arguments[0]);
        if (!on) return scpi_error(-224);
        if (const int code = conflict(where, function)) return scpi_error(code);
        for (auto* settings : where.settings) put(*settings, *on);
        return scpi_done();
      },
      [=, this](Arguments arguments) {
        const Targets where = targets(arguments);
        if (where.error != 0) return scpi_error(where.error);
        return list_of(where,
                       [&](ChannelSettings& one) { return std::string(get(one) ? "1" : "0"); });
      });
}

void KeithleyEmulator::add_sense_commands() {
  tree_.add(
      "[SENSe]:FUNCtion",
      [this](Arguments arguments) {
        Targets where = targets(arguments);
        if (where.error != 0) return scpi_error(where.error);
        if (arguments.size() != 1) return scpi_error(arguments.empty() ? -109 : -108);
        const auto function = function_from(arguments[0]);
        if (!function) return scpi_error(-224);
        for (std::size_t i = 0; i < where.channels.size(); ++i)
          if (is_four_wire(*function, where.settings[i]->frtd) &&
              !cards_.partner(where.channels[i]))
            return scpi_error(pairing_error_);
        for (auto* settings : where.settings) settings->function = *function;
        shrink_scan();
        return scpi_done();
      },
      [this](Arguments arguments) {
        const Targets where = targets(arguments);
        if (where.error != 0) return scpi_error(where.error);
        return list_of(where, [](ChannelSettings& one) { return function_text(one.function); });
      });
  add_function_commands("VOLTage[:DC]", Function::volt_dc);
  add_function_commands("VOLTage:AC", Function::volt_ac);
  add_function_commands("CURRent[:DC]", Function::curr_dc);
  add_function_commands("CURRent:AC", Function::curr_ac);
  add_function_commands("RESistance", Function::res);
  add_function_commands("FRESistance", Function::fres);
  add_function_commands("TEMPerature", Function::temp);
  add_flag(
      "[SENSe]:FRESistance:OCOMpensated", Function::fres,
      [](ChannelSettings& one) { return one.of(Function::fres).offset_compensated; },
      [](ChannelSettings& one, bool on) { one.of(Function::fres).offset_compensated = on; });
  add_temperature_commands();
}

void KeithleyEmulator::add_function_commands(const std::string& header, Function function) {
  const std::string sense = "[SENSe]:" + header;
  const bool ohms = function == Function::res || function == Function::fres;
  add_number(
      sense + ":NPLCycles", function, 0.01, mains_hz_ < 55 ? 50 : 60, 5,
      [function](ChannelSettings& one) { return one.of(function).nplc; },
      [function](ChannelSettings& one, double value) { return one.of(function).nplc = value, 0; });
  if (function != Function::temp) {
    add_number(
        sense + ":RANGe[:UPPer]", function, 0, ohms ? 120e6 : 1010, ohms ? 120e6 : 1000,
        [function](ChannelSettings& one) { return one.of(function).range; },
        [function, ohms](ChannelSettings& one, double value) {
          one.of(function).range = ohms ? resistance_range(value).value_or(0) : value;
          return 0;
        });
    add_flag(
        sense + ":RANGe:AUTO", function,
        [function](ChannelSettings& one) { return one.of(function).range == 0; },
        [function, ohms](ChannelSettings& one, bool on) {
          one.of(function).range = on ? 0 : ohms ? 1e3 : 10;
        });
  }
  add_flag(
      sense + ":AVERage[:STATe]", function,
      [function](ChannelSettings& one) { return one.of(function).filter_on; },
      [function](ChannelSettings& one, bool on) { one.of(function).filter_on = on; });
  add_number(
      sense + ":AVERage:COUNt", function, 1, 100, 10,
      [function](ChannelSettings& one) { return one.of(function).filter_count; },
      [function](ChannelSettings& one, double value) {
        return one.of(function).filter_count = static_cast<int>(value), 0;
      });
  tree_.add(
      sense + ":AVERage:TCONtrol",
      [this, function](Arguments arguments) {
        const Targets where = targets(arguments);
        if (where.error != 0) return scpi_error(where.error);
        if (arguments.size() != 1) return scpi_error(arguments.empty() ? -109 : -108);
        const std::string word = upper(arguments[0]);
        const bool repeat = word == "REP" || word == "REPEAT";
        if (!repeat && word != "MOV" && word != "MOVING") return scpi_error(-224);
        if (const int code = conflict(where, function)) return scpi_error(code);
        for (auto* settings : where.settings) settings->of(function).filter_repeats = repeat;
        return scpi_done();
      },
      [this, function](Arguments arguments) {
        const Targets where = targets(arguments);
        if (where.error != 0) return scpi_error(where.error);
        return list_of(where, [function](ChannelSettings& one) {
          return std::string(one.of(function).filter_repeats ? "REP" : "MOV");
        });
      });
}

void KeithleyEmulator::add_temperature_commands() {
  const auto words = [this](const std::string& header, auto get, auto put) {
    tree_.add(
        header,
        [=, this](Arguments arguments) {
          const Targets where = targets(arguments);
          if (where.error != 0) return scpi_error(where.error);
          if (arguments.size() != 1) return scpi_error(arguments.empty() ? -109 : -108);
          if (const int code = conflict(where, Function::temp)) return scpi_error(code);
          for (std::size_t i = 0; i < where.settings.size(); ++i)
            if (const int code = put(*where.settings[i], upper(arguments[0]),
                                     where.channels.empty() ? 0 : where.channels[i]))
              return scpi_error(code);
          shrink_scan();
          return scpi_done();
        },
        [=, this](Arguments arguments) {
          const Targets where = targets(arguments);
          if (where.error != 0) return scpi_error(where.error);
          return list_of(where, get);
        });
  };
  words(
      "[SENSe]:TEMPerature:TRANsducer",
      [](ChannelSettings& one) { return std::string(one.frtd ? "FRTD" : "TC"); },
      [this](ChannelSettings& one, const std::string& word, int channel) {
        const bool frtd = word == "FRTD";
        if (!frtd && word != "TC" && word != "TCOUPLE" && word != "THER" && word != "THERMISTOR")
          return -224;
        if (frtd && channel != 0 && !cards_.partner(channel)) return pairing_error_;
        one.frtd = frtd;
        return 0;
      });
  words(
      "[SENSe]:TEMPerature:FRTD:TYPE", [](ChannelSettings& one) { return one.frtd_type; },
      [](ChannelSettings& one, const std::string& word, int) {
        if (!rtd_constants(word) && word != "USER") return -224;
        one.frtd_type = word;
        return 0;
      });
  if (user_rtd_known_) {
    const auto constant = [this](const char* header, double min, double max, double fallback,
                                 double RtdConstants::*which) {
      add_number(
          header, Function::temp, min, max, fallback,
          [which](ChannelSettings& one) { return one.user.*which; },
          [which](ChannelSettings& one, double value) { return one.user.*which = value, 0; });
    };
    constant("[SENSe]:TEMPerature:FRTD:RZERo", 1e-3, 10000, 100, &RtdConstants::r0_ohm);
    constant("[SENSe]:TEMPerature:FRTD:ALPHa", 1e-6, 0.01, .00385, &RtdConstants::alpha);
    constant("[SENSe]:TEMPerature:FRTD:BETA", 0, 1, .111, &RtdConstants::beta);
    constant("[SENSe]:TEMPerature:FRTD:DELTa", 0, 5, 1.507, &RtdConstants::delta);
  }
  tree_.add(
      "UNIT:TEMPerature",
      [this](const Arguments& arguments) {
        if (arguments.size() != 1) return scpi_error(arguments.empty() ? -109 : -108);
        const std::string word = upper(arguments[0]);
        const bool known =
            word == "C" || word == "CEL" || word == "F" || word == "FAR" || word == "K";
        if (!known) return scpi_error(-224);
        temperature_unit_ = word[0];
        return scpi_done();
      },
      [this](const Arguments&) { return scpi_text(std::string(1, temperature_unit_)); });
}

}  // namespace driftwise::simulated
