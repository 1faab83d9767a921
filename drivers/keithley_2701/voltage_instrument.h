#pragma once
// Sensors whose output is a voltage, as an instrument of the cell: inclinometer, triangulation
// sensors, force sensor, motor current.
//
// read() gives each sensor's quantity, or z, rx and ry of a plate, and the voltages as they were
// read. A voltage outside its sensor's range is a state: the quantity is missing (kMissing), not an
// error; a voltage that the scanner cannot give is left out. A length counts from the last zero(),
// which is kept here and so outlives a broken line, but not the daemon; before the first one from
// the sensor's zero_v. start and end are the scanner's, in cell time.

#include <optional>

#include "drivers/keithley_2701/scanned_device.h"
#include "server/core/devices/voltage_sensors.h"
#include "server/core/ports/control/axis_follower.h"

namespace driftwise::keithley {

class VoltageInstrument : public ScannedDevice {
 public:
  VoltageInstrument(DeviceDescription device, std::shared_ptr<ScannerShare> share)
      : ScannedDevice(std::move(device), std::move(share)) {}

  Awaitable<Result<Reading>> read() override;
  // Of a length. Errors besides those of every device: failed_precondition NO_ZERO, an angle or a
  // force; OUT_OF_RANGE, the length is missing.
  Awaitable<Result<void>> zero() override;
  bool knows_its_zero() const override { return !device_.length() || zero_mm_; }

 protected:
  // Appends the quantity of the device's sensors, in their order. volts: kMissing where there is
  // none.
  virtual void add_quantities(const std::vector<double>& volts, Reading& reading) const;

 private:
  std::optional<double> zero_mm_;  // none: not zeroed since the start
};

// Force of a motor by its current, with the hysteresis of dry friction.
class MotorForceInstrument final : public VoltageInstrument, public AxisFollower {
 public:
  MotorForceInstrument(DeviceDescription device, std::shared_ptr<ScannerShare> share)
      : VoltageInstrument(std::move(device), std::move(share)),
        direction_(device_.voltages.motor->travel_mm) {}

  const Channel& followed_axis() const override { return device_.voltages.motor->axis; }
  void axis_at(double q_mm) override { direction_.moved_to(q_mm); }
  void axis_unknown() override { direction_.forget(); }

 protected:
  void add_quantities(const std::vector<double>& volts, Reading& reading) const override;

 private:
  FrictionDirection direction_;
};

}  // namespace driftwise::keithley
