#include "drivers/keithley_2701/voltage_instrument.h"

#include <cmath>

#include "server/core/reasons.h"
#include "server/core/text/shown_text.h"
#include "server/core/try.h"

namespace driftwise::keithley {
namespace {

std::string range_sentence(const VoltageSensor& sensor, double volts) {
  return "input " + std::to_string(sensor.input) + " shows " +
         (is_missing(volts) ? "no voltage" : number_text(volts) + " V") + ", its range is " +
         number_text(sensor.min_v) + " .. " + number_text(sensor.max_v) + " V";
}

}  // namespace

Awaitable<Result<Reading>> VoltageInstrument::read() {
  DRIFTWISE_CO_TRY(const auto scanned, co_await scan());
  Reading out = reading_of(scanned);
  std::vector<double> volts;
  for (const auto& sensor : device_.voltages.sensors) volts.push_back(scanned.value(sensor.input));
  add_quantities(volts, out);
  for (std::size_t i = 0; i < volts.size(); ++i)
    if (!is_missing(volts[i]))
      out.values.push_back(
          {voltage_channel(device_.id, device_.voltages.sensors[i]).name(), volts[i]});
  co_return out;
}

void VoltageInstrument::add_quantities(const std::vector<double>& volts, Reading& reading) const {
  const auto& sensors = device_.voltages.sensors;
  std::vector<double> values;
  for (std::size_t i = 0; i < sensors.size(); ++i)
    values.push_back(value_from_volts(sensors[i], volts[i]));
  if (device_.voltages.is_plate) {
    const auto pose = plate_pose(sensors, values);
    reading.values.push_back({device_.length()->channel.name(), pose.z_mm - zero_mm_.value_or(0)});
    reading.values.push_back({device_.angles()[0].channel.name(), pose.rx_arcsec});
    reading.values.push_back({device_.angles()[1].channel.name(), pose.ry_arcsec});
    return;
  }
  const double zero = device_.length() ? zero_mm_.value_or(0) : 0;
  for (std::size_t i = 0; i < sensors.size(); ++i)
    reading.values.push_back({sensors[i].channel.name(), values[i] - zero});
}

Awaitable<Result<void>> VoltageInstrument::zero() {
  const auto* length = device_.length();
  if (length == nullptr)
    co_return transport::no_zero(device_,
                                 "an angle or a force by a voltage has its own zero, zero_v");
  DRIFTWISE_CO_TRY(const auto reading, co_await read());
  const double* value_mm = reading.find(length->channel.name());
  if (value_mm != nullptr && !is_missing(*value_mm)) {
    zero_mm_ = zero_mm_.value_or(0) + *value_mm;
    co_return Result<void>{};
  }
  std::string found;
  for (const auto& sensor : device_.voltages.sensors) {
    const double* volts = reading.find(voltage_channel(device_.id, sensor).name());
    if (volts == nullptr || std::isnan(value_from_volts(sensor, *volts)))
      found += (found.empty() ? "" : "; ") + range_sentence(sensor, volts ? *volts : kMissing);
  }
  co_return fail(
      ErrorCode::failed_precondition, reasons::kOutOfRange,
      "device '" + device_.id + "': asked to zero, " + found + ": bring it into its range");
}

void MotorForceInstrument::add_quantities(const std::vector<double>& volts,
                                          Reading& reading) const {
  const auto& sensor = device_.voltages.sensors.front();
  const auto force = motor_force(value_from_volts(sensor, volts.front()), sensor.u,
                                 *device_.voltages.motor, direction_.now());
  const auto& symbol = sensor.channel.symbol;
  reading.values.push_back({sensor.channel.name(), force.newton});
  if (is_missing(force.newton)) return;
  reading.values.push_back({symbol + "_u_N", force.u_n});
  reading.values.push_back({symbol + "_dead_band_1", force.in_dead_band ? 1.0 : 0.0});
}

}  // namespace driftwise::keithley
