// TRIGger, SAMPle, INITiate, READ?, FETCh?: when readings are taken.

#include "drivers/simulated/emulators/keithley_2701/keithley_emulator.h"
#include "drivers/simulated/emulators/text.h"

namespace driftwise::simulated {
namespace {

constexpr int kMostReadings = 55000;

struct Number {
  double value = 0;
  int error = 0;
};

Number one_number(const ScpiTree::Arguments& arguments, double min, double max) {
  if (arguments.size() != 1) return {0, arguments.empty() ? -109 : -108};
  const auto value = parse_number(arguments[0]);
  if (!value) return {0, -104};
  if (*value < min || *value > max) return {0, -222};
  return {*value, 0};
}

}  // namespace

void KeithleyEmulator::add_trigger_commands() {
  tree_.add(
      "TRIGger[:SEQuence]:SOURce",
      [this](const Arguments& arguments) {
        if (arguments.size() != 1) return scpi_error(arguments.empty() ? -109 : -108);
        const std::string word = upper(arguments[0]);
        static const std::pair<const char*, const char*> kForms[] = {{"IMMEDIATE", "IMM"},
                                                                     {"TIMER", "TIM"},
                                                                     {"MANUAL", "MAN"},
                                                                     {"BUS", "BUS"},
                                                                     {"EXTERNAL", "EXT"}};
        for (const auto& [long_form, short_form] : kForms)
          if (word == long_form || word == short_form) {
            trigger_.source = short_form;
            return scpi_done();
          }
        return scpi_error(-224);
      },
      [this](const Arguments&) { return scpi_text(trigger_.source); });
  tree_.add(
      "TRIGger[:SEQuence]:COUNt",
      [this](const Arguments& arguments) {
        if (arguments.size() == 1 &&
            (upper(arguments[0]) == "INF" || upper(arguments[0]) == "INFINITY")) {
          trigger_.count = 0;
          return scpi_done();
        }
        const Number number = one_number(arguments, 1, kMostReadings);
        if (number.error == 0) trigger_.count = static_cast<int>(number.value);
        return number.error == 0 ? scpi_done() : scpi_error(number.error);
      },
      [this](const Arguments&) {
        return scpi_text(trigger_.count == 0 ? "+9.9E37" : std::to_string(trigger_.count));
      });
  tree_.add(
      "TRIGger[:SEQuence]:DELay",
      [this](const Arguments& arguments) {
        const Number number = one_number(arguments, 0, 999999.999);
        if (number.error != 0) return scpi_error(number.error);
        trigger_.delay_s = number.value;
        trigger_.delay_auto = false;
        return scpi_done();
      },
      [this](const Arguments&) { return scpi_text(scientific(trigger_.delay_s)); });
  tree_.add(
      "TRIGger[:SEQuence]:DELay:AUTO",
      [this](const Arguments& arguments) {
        if (arguments.size() != 1) return scpi_error(arguments.empty() ? -109 : -108);
        const std::string word = upper(arguments[0]);
        if (word != "ON" && word != "OFF" && word != "1" && word != "0") return scpi_error(-224);
        trigger_.delay_auto = word == "ON" || word == "1";
        return scpi_done();
      },
      [this](const Arguments&) { return scpi_bool(trigger_.delay_auto); });
  tree_.add(
      "TRIGger[:SEQuence]:TIMer",
      [this](const Arguments& arguments) {
        const Number number = one_number(arguments, 0, 999999.999);
        if (number.error == 0) trigger_.timer_s = number.value;
        return number.error == 0 ? scpi_done() : scpi_error(number.error);
      },
      [this](const Arguments&) { return scpi_text(scientific(trigger_.timer_s)); });
  tree_.add(
      "SAMPle:COUNt",
      [this](const Arguments& arguments) {
        const Number number = one_number(arguments, 1, kMostReadings);
        if (number.error != 0) return scpi_error(number.error);
        if (number.value > 1 && continuous_) return scpi_error(-221);
        samples_ = static_cast<int>(number.value);
        return scpi_done();
      },
      [this](const Arguments&) { return scpi_text(std::to_string(samples_)); });
  tree_.add(
      "INITiate:CONTinuous",
      [this](const Arguments& arguments) {
        if (arguments.size() != 1) return scpi_error(arguments.empty() ? -109 : -108);
        const std::string word = upper(arguments[0]);
        if (word != "ON" && word != "OFF" && word != "1" && word != "0") return scpi_error(-224);
        const bool on = word == "ON" || word == "1";
        if (on && samples_ > 1) return scpi_error(-221);
        continuous_ = on;
        return scpi_done();
      },
      [this](const Arguments&) { return scpi_bool(continuous_); });
  tree_.add(
      "INITiate[:IMMediate]", [this](const Arguments&) { return initiate(now_); }, nullptr);
  tree_.add(
      "ABORt", [this](const Arguments&) { return abort(), scpi_done(); }, nullptr);
  tree_.add(
      "*TRG",
      [this](const Arguments&) {
        if (!run_ || !run_->awaiting_trigger) return scpi_error(-211);
        run_->awaiting_trigger = false;
        next_sample(now_);
        return scpi_done();
      },
      nullptr);
  tree_.add("READ", nullptr, [this](const Arguments&) {
    abort();
    ScpiAnswer started = initiate(now_);
    if (started.error != 0) return started;
    pending_ = Pending::read;
    started.wait = true;
    return started;
  });
  const auto fetch = [this](const Arguments&) {
    if (continuous_ && !run_) {  // always measuring: the reading of this moment
      const int channel = closed_.value_or(0);
      const ChannelSettings& settings = channel == 0 ? front_ : settings_of(channel);
      readings_ = {{measure(settings, channel, now_), settings.function,
                    seconds_between(stamp_zero_, now_), 0, channel}};
    }
    if (readings_.empty()) return scpi_error(-230);
    return scpi_text(text_of(readings_, 0, readings_.size()));
  };
  tree_.add("FETCh", nullptr, fetch);
  tree_.add("[SENSe]:DATA[:LATest]", nullptr, fetch);
}

}  // namespace driftwise::simulated
