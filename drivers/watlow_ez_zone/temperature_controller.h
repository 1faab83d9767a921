#pragma once
// The blocking half: what a read and a set point are, in registers. Runs on the Modbus thread;
// holds no state but the line's.

#include <chrono>
#include <string>

#include "drivers/watlow_ez_zone/modbus_master.h"
#include "drivers/watlow_ez_zone/watlow_options.h"

namespace driftwise::watlow {

struct ControllerState {
  double process_degc = 0;  // kMissing with an input error
  double set_point_degc = 0;
  double power_pct = 0;  // heat positive, cool negative
  std::uint16_t input_error = kInputGood;
};

class TemperatureController {
 public:
  TemperatureController(ModbusMaster::Settings line, Options options);

  // Connects and checks the unit on the wire. Errors: failed_precondition UNIT_MISMATCH.
  Result<void> prepare(std::chrono::nanoseconds timeout);
  Result<ControllerState> read(std::chrono::nanoseconds timeout);
  // Writes the set point if it differs from the controller's by any bit, reads it back, and
  // switches to automatic. Errors: out_of_range SET_POINT (outside 5..60 degC); failed_precondition
  // IMPLAUSIBLE_PV (the process value is outside too: a wrong unit or word order would heat or cool
  // without end), INPUT_ERROR; data_loss NOT_TAKEN (it reads back differently).
  Result<void> set_point(double degc, std::chrono::nanoseconds timeout);

  Result<LoopTuning> tuning(std::chrono::nanoseconds timeout);
  // Writes what is set and differs from the controller's by any bit, reads all of it back. Errors:
  // out_of_range OUT_OF_RANGE (before anything is written); data_loss NOT_TAKEN;
  // MODBUS_EXCEPTION where the controller refuses.
  Result<LoopTuning> set_tuning(const LoopTuning& wanted, std::chrono::nanoseconds timeout);

  ModbusMaster& line() { return line_; }

 private:
  int at(int address) const { return address + (options_.zone - 1) * address::kZoneStride; }
  double temperature(std::span<const std::uint16_t, 2> registers) const;
  std::string name() const;

  std::string device_, address_text_;
  ModbusMaster line_;
  Options options_;
};

}  // namespace driftwise::watlow
