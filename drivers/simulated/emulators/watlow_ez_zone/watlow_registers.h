#pragma once
// The register map of a Watlow EZ-ZONE PM (PROTOCOLS section 4), addresses as they stand on the
// wire. Zone z of a gateway lies at +5000 * (z - 1). A float takes two registers; every other
// parameter one.
//
// Reads give the plant's state of that instant. A write of one half of a float takes effect with
// the other half as it is. Errors are Modbus exception codes: 2 for an address that is not there
// (or not writable), 3 for a value.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/simulated/emulators/switches.h"
#include "drivers/simulated/plant/plant.h"

namespace driftwise::simulated {

enum class ModbusException : std::uint8_t { none = 0, function = 1, address = 2, value = 3 };

class WatlowRegisters {
 public:
  static const std::vector<SwitchDescription>& switches();
  // first: the plant's stabiliser in zone 1. Throws SetupError.
  WatlowRegisters(PlantStabilisers& plant, const Switches& switches, int first, TimeNs power_on);

  // out has the size that is asked for.
  ModbusException read(int address, std::span<std::uint16_t> out, TimeNs now);
  // All or nothing.
  ModbusException write(int address, std::span<const std::uint16_t> values, TimeNs now);

 private:
  enum class Kind {
    process,
    input_error,
    heat_power,
    cool_power,
    mode,
    units,
    set_point,
    open_loop,
    heat_band,
    cool_band,
    integral,
    derivative,
    alarm_high,
    alarm_low
  };
  struct Parameter {
    int address;
    Kind kind;
    bool is_float, writable;
  };
  struct Zone {
    int stabiliser;
    int mode = 10;
    double open_loop_pct = 0;
    double heat_band_k = 2, cool_band_k = 2, integral_s = 180, derivative_s = 0;
    double alarm_high_degc = 40, alarm_low_degc = 5;
  };
  struct Place {
    Zone* zone;
    const Parameter* parameter;
    int word;  // 0 or 1: which register of the parameter
  };

  static const std::vector<Parameter>& map();
  std::optional<Place> find(int address);
  double get(const Zone& zone, Kind kind, TimeNs now);  // in the units on the wire
  ModbusException put(Zone& zone, Kind kind, double value, bool apply, TimeNs now);
  double to_wire_degrees(double degc) const;
  double from_wire_degrees(double value) const;
  double wire_degrees_per_kelvin() const;

  PlantStabilisers& plant_;
  bool low_word_first_, fahrenheit_, tuning_from_plant_;
  int error_open_, read_limit_;
  double min_set_degc_, max_set_degc_;
  std::vector<Zone> zones_;
};

}  // namespace driftwise::simulated
