// Common commands, SYSTem, FORMat, TRACe, STATus, DISPlay.

#include <algorithm>

#include "drivers/simulated/emulators/keithley_2701/keithley_emulator.h"
#include "drivers/simulated/emulators/text.h"

namespace driftwise::simulated {

void KeithleyEmulator::reset(bool preset) {
  abort();
  front_ = {};
  channels_.clear();
  scan_list_ = cards_.all();
  scanning_ = false;
  closed_.reset();
  trigger_ = {};
  trigger_.count = preset ? 0 : 1;
  samples_ = 1;
  continuous_ = preset;
  elements_ = kRead | kUnit | kStamp | kNumber;
  temperature_unit_ = 'C';
  stamp_type_ = "REL";
  buffer_fills_ = false;
  readings_.clear();
  opc_pending_ = false;
}

void KeithleyEmulator::add_system_commands() {
  const auto text = [this](std::string_view pattern, std::string reply) {
    tree_.add(pattern, nullptr,
              [reply = std::move(reply)](const Arguments&) { return scpi_text(reply); });
  };
  const auto ignored = [this](std::string_view pattern) {
    tree_.add(
        pattern, [](const Arguments&) { return scpi_done(); }, nullptr);
  };
  text("*IDN", identity_);
  text("*OPT", cards_.options());
  text("*TST", "0");
  text("SYSTem:VERSion", "1996.0");
  text("SYSTem:LFRequency", std::to_string(static_cast<int>(mains_hz_)));
  tree_.add(
      "*RST",
      [this](const Arguments&) { return reset(false), ScpiAnswer{.text = {}, .busy_s = reset_s_}; },
      nullptr);
  tree_.add(
      "SYSTem:PRESet",
      [this](const Arguments&) { return reset(true), ScpiAnswer{.text = {}, .busy_s = reset_s_}; },
      nullptr);
  tree_.add(
      "*CLS",
      [this](const Arguments&) {
        errors_.clear();
        event_status_ = 0;
        opc_pending_ = false;
        return ScpiAnswer{.text = {}, .busy_s = reset_s_};
      },
      nullptr);
  tree_.add(
      "*OPC",
      [this](const Arguments&) {
        if (run_)
          opc_pending_ = true;
        else
          event_status_ |= 1;
        return scpi_done();
      },
      [this](const Arguments&) {
        if (!run_) return scpi_text("1");
        pending_ = Pending::complete;
        return ScpiAnswer{.text = {}, .wait = true};
      });
  tree_.add(
      "*WAI",
      [this](const Arguments&) {
        if (!run_) return scpi_done();
        pending_ = Pending::complete;
        return ScpiAnswer{.text = {}, .wait = true};
      },
      nullptr);
  tree_.add("*ESR", nullptr, [this](const Arguments&) {
    return scpi_text(std::to_string(std::exchange(event_status_, 0)));
  });
  tree_.add("*STB", nullptr, [this](const Arguments&) {
    const unsigned byte =
        (errors_.empty() ? 0u : 4u) | ((event_status_ & event_enable_) != 0 ? 32u : 0u);
    return scpi_text(std::to_string(byte | ((byte & service_enable_) != 0 ? 64u : 0u)));
  });
  const auto mask = [this](std::string_view pattern, unsigned KeithleyEmulator::*member) {
    tree_.add(
        pattern,
        [this, member](const Arguments& arguments) {
          const auto value = arguments.size() == 1 ? parse_integer(arguments[0]) : std::nullopt;
          if (!value) return scpi_error(arguments.empty() ? -109 : -104);
          if (*value < 0 || *value > 255) return scpi_error(-222);
          this->*member = static_cast<unsigned>(*value);
          return scpi_done();
        },
        [this, member](const Arguments&) { return scpi_text(std::to_string(this->*member)); });
  };
  mask("*ESE", &KeithleyEmulator::event_enable_);
  mask("*SRE", &KeithleyEmulator::service_enable_);
  const auto next_error = [this](const Arguments&) { return scpi_text(errors_.pop()); };
  tree_.add("SYSTem:ERRor[:NEXT]", nullptr, next_error);
  tree_.add("STATus:QUEue[:NEXT]", nullptr, next_error);
  const auto clear = [this](const Arguments&) { return errors_.clear(), scpi_done(); };
  tree_.add("SYSTem:CLEar", clear, nullptr);
  tree_.add("STATus:QUEue:CLEar", clear, nullptr);
  ignored("STATus:PRESet");
  ignored("SYSTem:BEEPer[:STATe]");
  ignored("SYSTem:AZERo[:STATe]");
  ignored("SYSTem:LOCal");
  ignored("SYSTem:REMote");
  ignored("DISPlay:ENABle");
  tree_.add(
      "SYSTem:TSTamp:TYPE",
      [this](const Arguments& arguments) {
        if (arguments.size() != 1) return scpi_error(arguments.empty() ? -109 : -108);
        const std::string word = upper(arguments[0]);
        // The clock of the real instrument (RTCL) writes another format, which nothing here needs.
        if (word != "REL" && word != "RELATIVE") return scpi_error(-224);
        stamp_type_ = "REL";
        return scpi_done();
      },
      [this](const Arguments&) { return scpi_text(stamp_type_); });
  tree_.add(
      "SYSTem:TSTamp:RELative:RESet",
      [this](const Arguments&) { return stamp_zero_ = now_, scpi_done(); }, nullptr);
  struct Name {
    const char *short_form, *long_form;
    Element bit;
  };
  static const Name kElements[] = {{"READ", "READING", kRead},    {"UNIT", "UNITS", kUnit},
                                   {"TST", "TSTAMP", kStamp},     {"RNUM", "RNUMBER", kNumber},
                                   {"CHAN", "CHANNEL", kChannel}, {"LIM", "LIMITS", kLimit}};
  tree_.add(
      "FORMat:ELEMents",
      [this](const Arguments& arguments) {
        if (arguments.empty()) return scpi_error(-109);
        unsigned chosen = 0;
        for (const auto& argument : arguments) {
          const std::string word = upper(argument);
          const auto* found = std::find_if(
              std::begin(kElements), std::end(kElements),
              [&](const Name& one) { return word == one.short_form || word == one.long_form; });
          if (found == std::end(kElements)) return scpi_error(-224);
          chosen |= found->bit;
        }
        elements_ = chosen;
        return scpi_done();
      },
      [this](const Arguments&) {  // six places always: "READ,,,,,"
        std::string reply;
        int places = 0;
        for (const auto& one : kElements)
          if ((elements_ & one.bit) != 0)
            reply += (places++ == 0 ? "" : ",") + std::string(one.short_form);
        return scpi_text(reply + std::string(static_cast<std::size_t>(6 - places), ','));
      });
  tree_.add(
      "FORMat[:DATA]",
      [](const Arguments& arguments) {
        if (arguments.empty()) return scpi_error(-109);
        const std::string word = upper(arguments[0]);
        return word == "ASC" || word == "ASCII" ? scpi_done() : scpi_error(-224);
      },
      [](const Arguments&) { return scpi_text("ASC"); });
}

void KeithleyEmulator::add_buffer_commands() {
  const auto word = [](const Arguments& arguments) {
    return arguments.size() == 1 ? upper(arguments[0]) : std::string();
  };
  tree_.add(
      "TRACe:CLEar",
      [this](const Arguments&) {
        buffer_.clear();
        buffer_.shrink_to_fit();
        return scpi_done();
      },
      nullptr);
  tree_.add(
      "TRACe:POINts",
      [this](const Arguments& arguments) {
        const auto value = arguments.size() == 1 ? parse_integer(arguments[0]) : std::nullopt;
        if (!value) return scpi_error(arguments.empty() ? -109 : -104);
        if (*value < 2 || *value > 55000) return scpi_error(-222);
        buffer_size_ = *value;
        buffer_.clear();
        return scpi_done();
      },
      [this](const Arguments&) { return scpi_text(std::to_string(buffer_size_)); });
  tree_.add("TRACe:POINts:ACTual", nullptr,
            [this](const Arguments&) { return scpi_text(std::to_string(buffer_.size())); });
  tree_.add(
      "TRACe:FEED",
      [word](const Arguments& arguments) {
        const std::string source = word(arguments);
        return source == "SENS" || source == "SENSE" || source == "SENS1" ? scpi_done()
                                                                          : scpi_error(-224);
      },
      [](const Arguments&) { return scpi_text("SENS"); });
  tree_.add(
      "TRACe:FEED:CONTrol",
      [this, word](const Arguments& arguments) {
        const std::string control = word(arguments);
        if (control != "NEXT" && control != "NEV" && control != "NEVER") return scpi_error(-224);
        buffer_fills_ = control == "NEXT";
        if (buffer_fills_) buffer_.clear();
        return scpi_done();
      },
      [this](const Arguments&) { return scpi_text(buffer_fills_ ? "NEXT" : "NEV"); });
  tree_.add("TRACe:DATA", nullptr, [this](const Arguments&) {
    if (buffer_.empty()) return scpi_error(-230);
    return scpi_text(text_of(buffer_, 0, buffer_.size()));
  });
  tree_.add("TRACe:DATA:SELected", nullptr, [this](const Arguments& arguments) {
    if (arguments.size() != 2) return scpi_error(-109);
    const auto from = parse_integer(arguments[0]);
    const auto count = parse_integer(arguments[1]);
    if (!from || !count) return scpi_error(-104);
    if (*from < 0 || *count < 1 ||
        static_cast<std::size_t>(*from) + static_cast<std::size_t>(*count) > buffer_.size())
      return scpi_error(-222);
    return scpi_text(
        text_of(buffer_, static_cast<std::size_t>(*from), static_cast<std::size_t>(*count)));
  });
}

}  // namespace driftwise::simulated
