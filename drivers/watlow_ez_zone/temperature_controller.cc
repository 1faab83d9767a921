#include "drivers/watlow_ez_zone/temperature_controller.h"

#include <algorithm>
#include <cstdio>
#include <iterator>

#include "server/core/data/reading.h"
#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::watlow {
namespace {

using Pair = std::span<const std::uint16_t, 2>;

Pair pair_at(const std::vector<std::uint16_t>& registers, std::size_t index) {
  return Pair(registers.data() + index, 2);
}

std::string degrees(double degc) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g degC", degc);
  return text;
}

}  // namespace

TemperatureController::TemperatureController(ModbusMaster::Settings line, Options options)
    : device_(line.device),
      address_text_(line.address_text),
      line_(std::move(line)),
      options_(options) {}

std::string TemperatureController::name() const {
  return "device '" + device_ + "' at " + address_text_ + ": ";
}

double TemperatureController::temperature(Pair registers) const {
  return degc_from_wire(unpack_float(registers, options_.word_order), options_.unit);
}

Result<void> TemperatureController::prepare(std::chrono::nanoseconds timeout) {
  line_.set_timeout(timeout);
  if (line_.connected()) return {};
  if (auto up = line_.connect(timeout); !up) return up;
  if (!options_.check_unit) return {};
  const auto unit = line_.read(at(address::kUnit), 1);
  const std::uint16_t wanted = options_.unit == Unit::celsius ? kUnitCelsius : kUnitFahrenheit;
  if (unit && (*unit)[0] == wanted) return {};
  line_.disconnect();  // so that the next call checks again
  DRIFTWISE_RETURN_IF_ERROR(unit);
  return fail(ErrorCode::failed_precondition, reasons::kUnitMismatch,
              name() + "option unit = " + (options_.unit == Unit::celsius ? "C" : "F") +
                  ", but register 2490 holds " + describe_unit((*unit)[0]) +
                  ": correct the option or the controller");
}

Result<ControllerState> TemperatureController::read(std::chrono::nanoseconds timeout) {
  DRIFTWISE_RETURN_IF_ERROR(prepare(timeout));
  DRIFTWISE_TRY(const auto process,
                line_.read(at(address::kProcessValue), 3));  // the input error stands behind it
  DRIFTWISE_TRY(const auto power, line_.read(at(address::kHeatPower), 4));
  DRIFTWISE_TRY(const auto set_point, line_.read(at(address::kSetPoint), 2));
  ControllerState out;
  out.input_error = process[2];
  out.process_degc = out.input_error == kInputGood ? temperature(pair_at(process, 0)) : kMissing;
  out.set_point_degc = temperature(pair_at(set_point, 0));
  const float heat = unpack_float(pair_at(power, 0), options_.word_order);
  const float cool = unpack_float(pair_at(power, 2), options_.word_order);
  out.power_pct = static_cast<double>(heat) - static_cast<double>(cool);
  return out;
}

Result<void> TemperatureController::set_point(double degc, std::chrono::nanoseconds timeout) {
  if (!is_plausible(degc)) {
    return fail(
        ErrorCode::out_of_range, reasons::kSetPoint,
        name() + "set point " + degrees(degc) + ", allowed are 5 .. 60 degC; nothing was written");
  }
  DRIFTWISE_TRY(const auto now, read(timeout));
  if (now.input_error != kInputGood) {
    return fail(ErrorCode::failed_precondition, reasons::kInputError,
                name() + "input error " + describe_input_error(now.input_error) +
                    ": mend the sensor; nothing was written");
  }
  if (!is_plausible(now.process_degc)) {
    return fail(
        ErrorCode::failed_precondition, reasons::kImplausiblePv,
        name() + "process value reads as " + degrees(now.process_degc) +
            ", expected 5 .. 60: check the options word_order and unit; nothing was written");
  }
  const auto wanted = pack_float(wire_from_degc(degc, options_.unit), options_.word_order);
  DRIFTWISE_TRY(const auto present, line_.read(at(address::kSetPoint), 2));
  if (!std::equal(wanted.begin(), wanted.end(), present.begin())) {
    if (auto written = line_.write(at(address::kSetPoint), wanted); !written) return written;
    DRIFTWISE_TRY(const auto after, line_.read(at(address::kSetPoint), 2));
    if (!std::equal(wanted.begin(), wanted.end(), after.begin())) {
      return fail(ErrorCode::data_loss, reasons::kNotTaken,
                  name() + "set point " + degrees(degc) + " reads back as " +
                      degrees(temperature(pair_at(after, 0))) +
                      ": is it limited on the controller's panel?");
    }
  }
  DRIFTWISE_TRY(const auto mode, line_.read(at(address::kMode), 1));
  if (mode[0] == kModeAutomatic) return {};
  return line_.write(at(address::kMode), std::span(&kModeAutomatic, 1));
}

namespace {

// In the order of their registers, from kHeatBand on.
struct TuningRegister {
  const char* name;
  std::optional<double> LoopTuning::*value;
  bool band;
  double min, max;  // K or s
};
constexpr TuningRegister kTuning[] = {
    {"heat band", &LoopTuning::heat_band_k, true, 0.001, 5000},
    {"cool band", &LoopTuning::cool_band_k, true, 0.001, 5000},
    {"integral", &LoopTuning::integral_s, false, 0, 9999},
    {"derivative", &LoopTuning::derivative_s, false, 0, 9999},
};
constexpr int kTuningRegisters = 2 * static_cast<int>(std::size(kTuning));

}  // namespace

Result<LoopTuning> TemperatureController::tuning(std::chrono::nanoseconds timeout) {
  DRIFTWISE_RETURN_IF_ERROR(prepare(timeout));
  DRIFTWISE_TRY(const auto words, line_.read(at(address::kHeatBand), kTuningRegisters));
  LoopTuning out;
  for (std::size_t i = 0; i < std::size(kTuning); ++i) {
    const float value = unpack_float(pair_at(words, 2 * i), options_.word_order);
    out.*kTuning[i].value =
        kTuning[i].band ? kelvin_from_wire(value, options_.unit) : static_cast<double>(value);
  }
  return out;
}

Result<LoopTuning> TemperatureController::set_tuning(const LoopTuning& wanted,
                                                     std::chrono::nanoseconds timeout) {
  for (const auto& one : kTuning) {
    const auto& value = wanted.*one.value;
    if (!value || (*value >= one.min && *value <= one.max)) continue;
    char text[96];
    std::snprintf(text, sizeof text, "%s %.6g %s, allowed are %g .. %g; nothing was written",
                  one.name, *value, one.band ? "K" : "s", one.min, one.max);
    return fail(ErrorCode::out_of_range, reasons::kOutOfRange, name() + text);
  }
  DRIFTWISE_RETURN_IF_ERROR(prepare(timeout));
  DRIFTWISE_TRY(const auto present, line_.read(at(address::kHeatBand), kTuningRegisters));
  std::vector<std::uint16_t> expected = present;
  const auto place_of = [](std::size_t i) { return static_cast<std::ptrdiff_t>(2 * i); };
  for (std::size_t i = 0; i < std::size(kTuning); ++i) {
    const auto& value = wanted.*kTuning[i].value;
    if (!value) continue;
    const auto words = pack_float(
        kTuning[i].band ? wire_from_kelvin(*value, options_.unit) : static_cast<float>(*value),
        options_.word_order);
    std::copy(words.begin(), words.end(), expected.begin() + place_of(i));
    if (std::equal(words.begin(), words.end(), present.begin() + place_of(i))) continue;
    DRIFTWISE_RETURN_IF_ERROR(line_.write(at(address::kHeatBand) + 2 * static_cast<int>(i), words));
  }
  DRIFTWISE_TRY(const auto taken, line_.read(at(address::kHeatBand), kTuningRegisters));
  DRIFTWISE_TRY(auto after, tuning(timeout));
  for (std::size_t i = 0; i < std::size(kTuning); ++i)
    if (wanted.*kTuning[i].value &&
        !std::equal(taken.begin() + place_of(i), taken.begin() + place_of(i) + 2,
                    expected.begin() + place_of(i)))
      return fail(ErrorCode::data_loss, reasons::kNotTaken,
                  name() + "the control parameters read back as " + tuning_text(after) +
                      ": are they locked on the controller's panel?");
  return after;
}

}  // namespace driftwise::watlow
