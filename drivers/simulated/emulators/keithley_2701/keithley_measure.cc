// The acquisition: samples one after the other in cell time, and what a sample looks like on the
// wire.

#include <cmath>

#include "drivers/simulated/emulators/keithley_2701/keithley_emulator.h"
#include "drivers/simulated/emulators/text.h"

namespace driftwise::simulated {
namespace {

constexpr double kOverflow = 9.9e37;
constexpr double kStampWraps_s = 99999.99;  // the relative time stamp starts again from zero

}  // namespace

ScpiAnswer KeithleyEmulator::initiate(TimeNs now) {
  if (continuous_ || run_) return scpi_error(-213);
  if (scanning_ && scan_list_.empty()) return scpi_error(-221);
  Run run;
  if (scanning_)
    run.channels = scan_list_;
  else
    run.channels = {closed_.value_or(0)};
  readings_.clear();
  run_ = std::move(run);
  run_->scan_start = now;
  run_->awaiting_trigger = trigger_.source != "IMM" && trigger_.source != "TIM";
  if (!run_->awaiting_trigger) next_sample(now);
  return scpi_done();
}

void KeithleyEmulator::abort() {
  if (run_ && run_->event) timeline_.cancel(*run_->event);
  run_.reset();
}

void KeithleyEmulator::next_sample(TimeNs now) {
  const int channel =
      run_->channels[static_cast<std::size_t>(run_->sample) % run_->channels.size()];
  const ChannelSettings& settings = channel == 0 ? front_ : settings_of(channel);
  double duration_s = integration_s(settings, mains_hz_);
  if (scanning_) duration_s += relay_s_;
  if (!trigger_.delay_auto) duration_s += trigger_.delay_s;
  run_->event =
      timeline_.at(now + nanoseconds_from(duration_s), [this](TimeNs due) { sampled(due); });
}

void KeithleyEmulator::sampled(TimeNs now) {
  run_->event.reset();
  const int channel =
      run_->channels[static_cast<std::size_t>(run_->sample) % run_->channels.size()];
  const ChannelSettings& settings = channel == 0 ? front_ : settings_of(channel);
  const Sample sample{measure(settings, channel, now), settings.function,
                      std::fmod(seconds_between(stamp_zero_, now), kStampWraps_s),
                      static_cast<long>(run_->sample), channel};
  readings_.push_back(sample);
  if (buffer_fills_) {
    buffer_.push_back(sample);
    buffer_.back().number = static_cast<long>(buffer_.size()) - 1;
    if (buffer_.size() >= static_cast<std::size_t>(buffer_size_)) buffer_fills_ = false;
  }
  if (++run_->sample < samples_) {
    next_sample(now);
    return;
  }
  if (trigger_.count != 0 && ++run_->scan >= trigger_.count) {
    run_.reset();
    finished(now);
    return;
  }
  // A further scan overwrites the one before: readings_ holds the last one when all are done.
  run_->sample = 0;
  if (trigger_.source != "IMM" && trigger_.source != "TIM") {
    run_->awaiting_trigger = true;
    return;
  }
  const TimeNs timed = run_->scan_start + nanoseconds_from(trigger_.timer_s);
  run_->scan_start = trigger_.source == "TIM" ? std::max(timed, now) : now;
  run_->event = timeline_.at(run_->scan_start, [this](TimeNs due) {
    readings_.clear();
    next_sample(due);
  });
}

void KeithleyEmulator::finished(TimeNs now) {
  if (opc_pending_) {
    event_status_ |= 1;
    opc_pending_ = false;
  }
  const Pending pending = pending_;
  if (pending == Pending::read) resume(scpi_text(text_of(readings_, 0, readings_.size())), now);
  if (pending == Pending::complete) resume(scpi_text("1"), now);
}

double KeithleyEmulator::measured_volt(const ChannelSettings& settings, int channel, TimeNs now) {
  constexpr double kOverRange = 1.01;  // of every range but the highest, which ends at 1010 V
  double volt = 0;
  const int repeats = settings.now().filter_on ? settings.now().filter_count : 1;
  for (int i = 0; i < repeats; ++i) volt += plant_.input_volt(channel, now) / repeats;
  double range = 0.1;
  const double wanted = settings.now().range > 0 ? settings.now().range : std::abs(volt);
  while (range < 1000 && wanted > range * kOverRange) range *= 10;
  if (!std::isfinite(volt) || std::abs(volt) > range * kOverRange) return kOverflow;
  const double step = range * 1e-7;
  return std::round(volt / step) * step;
}

double KeithleyEmulator::measure(const ChannelSettings& settings, int channel, TimeNs now) {
  const Function function = settings.function;
  if (function == Function::volt_dc && channel != 0 && plant_.has_voltage(channel))
    return measured_volt(settings, channel, now);
  const bool resistive = function == Function::fres || function == Function::res ||
                         function == Function::cont ||
                         (function == Function::temp && settings.frtd);
  if (!resistive) return function == Function::temp ? kOverflow : 0.0;  // nothing is connected
  if (channel == 0 || !plant_.has_probe(channel)) return kOverflow;
  double ohm = 0;
  const int repeats = settings.now().filter_on ? settings.now().filter_count : 1;
  for (int i = 0; i < repeats; ++i) ohm += plant_.probe_ohm(channel, now) / repeats;
  if (!std::isfinite(ohm)) return kOverflow;
  if (function == Function::temp) {
    const auto degc = rtd_degc(ohm, settings.rtd());
    if (!degc) return kOverflow;
    const double c = std::round(*degc * 1000) / 1000;  // three decimals of a degree on the bus
    return temperature_unit_ == 'F' ? c * 1.8 + 32 : temperature_unit_ == 'K' ? c + 273.15 : c;
  }
  if (function != Function::fres) ohm += lead_ohm_;
  const double range =
      settings.now().range > 0 ? settings.now().range : resistance_range(ohm).value_or(100e6);
  if (ohm > 1.2 * range) return kOverflow;
  const double step = range * 1e-7;  // the bus carries one digit more than the display
  return std::round(ohm / step) * step;
}

std::string KeithleyEmulator::text_of(const Sample& sample) const {
  const bool overflow = sample.value >= kOverflow;
  const bool units = (elements_ & kUnit) != 0;
  std::string text;
  const auto field = [&text](std::string piece) { text += (text.empty() ? "" : ",") + piece; };
  if ((elements_ & kRead) != 0)
    field((overflow ? "+9.9E37" : scientific(sample.value)) +
          (units ? function_unit(sample.function, temperature_unit_) : ""));
  if ((elements_ & kStamp) != 0) field("+" + fixed(sample.stamp_s, 3) + (units ? "SECS" : ""));
  if ((elements_ & kNumber) != 0)
    field("+" + std::to_string(sample.number) + (units ? "RDNG#" : ""));
  if ((elements_ & kChannel) != 0) {
    std::string channel = std::to_string(sample.channel);
    channel.insert(0, 3 - std::min<std::size_t>(3, channel.size()), '0');
    field(channel + (units && channel_suffix_ ? "INTCHAN" : ""));
  }
  if ((elements_ & kLimit) != 0) field(std::string("0000") + (units ? "LIMITS" : ""));
  return text;
}

std::string KeithleyEmulator::text_of(const std::vector<Sample>& samples, std::size_t from,
                                      std::size_t count) const {
  std::string text;
  for (std::size_t i = from; i < from + count && i < samples.size(); ++i)
    text += (text.empty() ? "" : ",") + text_of(samples[i]);
  return text;
}

}  // namespace driftwise::simulated
