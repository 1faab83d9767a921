#include "drivers/simulated/emulators/watlow_ez_zone/watlow_registers.h"

#include <array>
#include <bit>
#include <cmath>
#include <map>

#include "drivers/simulated/emulators/text.h"

namespace driftwise::simulated {
namespace {

constexpr int kZoneStride = 5000;
constexpr int kModeAuto = 10, kModeManual = 54, kModeOff = 62;
constexpr int kUnitsFahrenheit = 30, kUnitsCelsius = 15;
constexpr int kInputErrorNone = 61;

std::array<std::uint16_t, 2> words_of(double value, bool low_first) {
  const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(value));
  const auto high = static_cast<std::uint16_t>(bits >> 16);
  const auto low = static_cast<std::uint16_t>(bits & 0xFFFF);
  if (low_first) return {low, high};
  return {high, low};
}

double float_from(std::array<std::uint16_t, 2> words, bool low_first) {
  const std::uint32_t high = low_first ? words[1] : words[0];
  const std::uint32_t low = low_first ? words[0] : words[1];
  return static_cast<double>(std::bit_cast<float>(high << 16 | low));
}

}  // namespace

const std::vector<SwitchDescription>& WatlowRegisters::switches() {
  static const std::vector<SwitchDescription> kAll{
      {"unit_id", "1", "own", "Modbus address; a request to another one gets no answer"},
      {"low_word_first", "true", "M", "order of the two words of a float"},
      {"fahrenheit", "true", "M",
       "units on the wire after power-on (register 2490): degF, else degC"},
      {"input_error_open", "65", "U", "code of register 362 for an open sensor"},
      {"zones", "1", "D", "control zones behind this address, +5000 registers each"},
      {"min_set_degC", "0", "own", "below it a set point is refused with exception 3"},
      {"max_set_degC", "80", "own", "above it a set point is refused with exception 3"},
      {"tuning_at_start", "keep", "own",
       "keep: the plant's own tuning until a band or time is written or factory: bands 2 K, Ti 180 "
       "s"},
      {"read_limit", "125", "M", "registers per read; more give exception 3"},
      {"latency_s", "0.01", "own", "from the end of a request to its reply"},
      {"rtu", "false", "own", "also serve RTU frames on a pseudo-terminal (printed in READY)"},
      {"rtu_gap_s", "0.05", "own", "silence after which an unfinished RTU frame is dropped"},
      {"max_clients", "8", "U", "TCP connections at a time; one more is closed at once"},
  };
  return kAll;
}

WatlowRegisters::WatlowRegisters(PlantStabilisers& plant, const Switches& s, int first,
                                 TimeNs power_on)
    : plant_(plant),
      low_word_first_(s.flag("low_word_first")),
      fahrenheit_(s.flag("fahrenheit")),
      tuning_from_plant_(s.choice("tuning_at_start", {"keep", "factory"}) == "keep"),
      error_open_(s.integer("input_error_open", 0, 65535)),
      read_limit_(s.integer("read_limit", 1, 125)),
      min_set_degc_(s.number("min_set_degC", -200, 1000)),
      max_set_degc_(s.number("max_set_degC", -200, 1000)) {
  const int zones = s.integer("zones", 1, 12);
  if (first < 0 || first + zones > plant.stabiliser_count())
    throw SetupError("[emulator.watlow] zones: asked for the plant's stabilisers " +
                     std::to_string(first + 1) + " to " + std::to_string(first + zones) +
                     ", it has " + std::to_string(plant.stabiliser_count()));
  for (int i = 0; i < zones; ++i) {
    zones_.push_back(Zone{.stabiliser = first + i});
    if (!tuning_from_plant_)
      put(zones_.back(), Kind::heat_band, 2 * wire_degrees_per_kelvin(), true, power_on);
  }
}

const std::vector<WatlowRegisters::Parameter>& WatlowRegisters::map() {
  static const std::vector<Parameter> kMap{
      {360, Kind::process, true, false},     {362, Kind::input_error, false, false},
      {1480, Kind::alarm_high, true, true},  {1482, Kind::alarm_low, true, true},
      {1880, Kind::mode, false, true},       {1890, Kind::heat_band, true, true},
      {1892, Kind::cool_band, true, true},   {1894, Kind::integral, true, true},
      {1896, Kind::derivative, true, true},  {1904, Kind::heat_power, true, false},
      {1906, Kind::cool_power, true, false}, {2160, Kind::set_point, true, true},
      {2162, Kind::open_loop, true, true},   {2490, Kind::units, false, true},
  };
  return kMap;
}

std::optional<WatlowRegisters::Place> WatlowRegisters::find(int address) {
  const int zone = address / kZoneStride;
  if (address < 0 || zone >= static_cast<int>(zones_.size())) return std::nullopt;
  const int inside = address % kZoneStride;
  for (const auto& parameter : map()) {
    const int word = inside - parameter.address;
    if (word == 0 || (word == 1 && parameter.is_float))
      return Place{&zones_[static_cast<std::size_t>(zone)], &parameter, word};
  }
  return std::nullopt;
}

double WatlowRegisters::get(const Zone& zone, Kind kind, TimeNs now) {
  const StabiliserState state = plant_.stabiliser(zone.stabiliser, now);
  switch (kind) {
    case Kind::process:
      return to_wire_degrees(state.process_degc);
    case Kind::set_point:
      return to_wire_degrees(state.set_point_degc);
    case Kind::heat_power:
      return state.heat_pct;
    case Kind::cool_power:
      return state.cool_pct;
    case Kind::input_error:
      return state.sensor_open ? error_open_ : kInputErrorNone;
    case Kind::mode:
      return zone.mode;
    case Kind::units:
      return fahrenheit_ ? kUnitsFahrenheit : kUnitsCelsius;
    case Kind::open_loop:
      return zone.open_loop_pct;
    case Kind::heat_band:
      return zone.heat_band_k * wire_degrees_per_kelvin();
    case Kind::cool_band:
      return zone.cool_band_k * wire_degrees_per_kelvin();
    case Kind::integral:
      return zone.integral_s;
    case Kind::derivative:
      return zone.derivative_s;
    case Kind::alarm_high:
      return to_wire_degrees(zone.alarm_high_degc);
    case Kind::alarm_low:
      return to_wire_degrees(zone.alarm_low_degc);
  }
  return 0;
}

ModbusException WatlowRegisters::put(Zone& zone, Kind kind, double value, bool apply, TimeNs now) {
  if (!std::isfinite(value)) return ModbusException::value;
  const auto within = [value](double min, double max) { return value >= min && value <= max; };
  const auto keep = [&](double& place, double kept) {
    if (apply) place = kept;
  };
  switch (kind) {
    case Kind::set_point: {
      const double degc = from_wire_degrees(value);
      if (degc < min_set_degc_ || degc > max_set_degc_) return ModbusException::value;
      if (apply) plant_.set_set_point_degc(zone.stabiliser, degc, now);
      return ModbusException::none;
    }
    case Kind::units:
      if (value != kUnitsFahrenheit && value != kUnitsCelsius) return ModbusException::value;
      if (apply) fahrenheit_ = value == kUnitsFahrenheit;
      return ModbusException::none;
    case Kind::mode:
      if (value != kModeAuto && value != kModeManual && value != kModeOff)
        return ModbusException::value;
      if (apply) zone.mode = static_cast<int>(value);
      break;
    case Kind::open_loop:
      if (!within(-100, 100)) return ModbusException::value;
      keep(zone.open_loop_pct, value);
      break;
    case Kind::alarm_high:
      keep(zone.alarm_high_degc, from_wire_degrees(value));
      return ModbusException::none;
    case Kind::alarm_low:
      keep(zone.alarm_low_degc, from_wire_degrees(value));
      return ModbusException::none;
    case Kind::heat_band:
    case Kind::cool_band:
    case Kind::integral:
    case Kind::derivative: {
      if (!within(0, 9999)) return ModbusException::value;
      const bool band = kind == Kind::heat_band || kind == Kind::cool_band;
      double& place = kind == Kind::heat_band   ? zone.heat_band_k
                      : kind == Kind::cool_band ? zone.cool_band_k
                      : kind == Kind::integral  ? zone.integral_s
                                                : zone.derivative_s;
      keep(place, band ? value / wire_degrees_per_kelvin() : value);
      if (apply)
        plant_.set_stabiliser_tuning(zone.stabiliser, zone.heat_band_k, zone.cool_band_k,
                                     zone.integral_s, zone.derivative_s, now);
      return ModbusException::none;
    }
    default:
      return ModbusException::address;
  }
  if (apply) {
    using Mode = PlantStabilisers::StabiliserMode;
    const Mode mode = zone.mode == kModeAuto     ? Mode::automatic
                      : zone.mode == kModeManual ? Mode::manual
                                                 : Mode::off;
    plant_.set_stabiliser_mode(zone.stabiliser, mode, zone.open_loop_pct, now);
  }
  return ModbusException::none;
}

ModbusException WatlowRegisters::read(int address, std::span<std::uint16_t> out, TimeNs now) {
  if (out.empty() || static_cast<int>(out.size()) > read_limit_) return ModbusException::value;
  // One float is one value: both words are taken from the same evaluation, the plant's noise would
  // tear them.
  std::map<std::pair<const Zone*, const Parameter*>, double> values;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const auto place = find(address + static_cast<int>(i));
    if (!place) return ModbusException::address;
    const auto key = std::make_pair(static_cast<const Zone*>(place->zone), place->parameter);
    if (!values.contains(key)) values[key] = get(*place->zone, place->parameter->kind, now);
    out[i] = place->parameter->is_float
                 ? words_of(values[key], low_word_first_)[static_cast<std::size_t>(place->word)]
                 : static_cast<std::uint16_t>(values[key]);
  }
  return ModbusException::none;
}

ModbusException WatlowRegisters::write(int address, std::span<const std::uint16_t> values,
                                       TimeNs now) {
  struct Change {
    Place place;
    std::array<std::uint16_t, 2> words;
  };
  std::vector<Change> changes;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto place = find(address + static_cast<int>(i));
    if (!place || !place->parameter->writable) return ModbusException::address;
    const bool same = !changes.empty() && changes.back().place.zone == place->zone &&
                      changes.back().place.parameter == place->parameter;
    if (!same) {
      changes.push_back({*place, {values[i], 0}});
      if (place->parameter->is_float)
        changes.back().words =
            words_of(get(*place->zone, place->parameter->kind, now), low_word_first_);
    }
    changes.back().words[static_cast<std::size_t>(place->word)] = values[i];
  }
  for (const bool apply : {false, true})
    for (const auto& [place, words] : changes) {
      const double value =
          place.parameter->is_float ? float_from(words, low_word_first_) : words[0];
      const auto refused = put(*place.zone, place.parameter->kind, value, apply, now);
      if (refused != ModbusException::none) return refused;
    }
  return ModbusException::none;
}

double WatlowRegisters::to_wire_degrees(double degc) const {
  return fahrenheit_ ? degc * 1.8 + 32.0 : degc;
}
double WatlowRegisters::from_wire_degrees(double value) const {
  return fahrenheit_ ? (value - 32.0) / 1.8 : value;
}
double WatlowRegisters::wire_degrees_per_kelvin() const { return fahrenheit_ ? 1.8 : 1.0; }

}  // namespace driftwise::simulated
