#pragma once
// One [[device]] of a cell file: what all devices have, and the settings of its role.

#include <map>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "server/core/channel.h"
#include "server/core/devices/device_role.h"
#include "server/core/devices/voltage_sensors.h"

namespace driftwise {

// A pt1000 in four-wire ohms behind one scanner input: R(t) = R0 (1 + A t + B t^2), t >= 0 degC
// (IEC 60751).
struct ProbeDescription {
  Channel channel;  // t07_degC
  int input = 0;    // scanner channel number, 101..
  double r0_ohm = 1000.0, a_per_degc = 3.9083e-3, b_per_degc2 = -5.775e-7;
  std::string place;  // "upper flexure arm": for people
  std::string part;   // "robot", "instrument" or "air": which sensors a served model may use
  double u_k = 0.0;   // certificate: standard uncertainty, K
};

struct AxisDescription {
  Channel channel;                // q1_mm, as read back from the scale
  std::string device_axis;        // the controller's name for it: "X"
  double min_mm = 0, max_mm = 0;  // soft limits: nothing moves outside, whoever asks
  double u_scale_nm = 0;          // declared standard uncertainty of the scale
};

// One axis of an instrument for angles. A device turns its spot to its own liking; sign makes the
// reading a right-handed rotation about the cell's axis.
struct AngleDescription {
  Channel channel;      // ry_arcsec
  int device_axis = 1;  // the instrument's number for it, 1 or 2
  int sign = 1;         // 1 or -1
  double u_arcsec = 0;  // declared standard uncertainty
};

// One further quantity that an instrument gives under its own name.
struct QuantityDescription {
  Channel channel;  // pressure_hPa
  double u = 0;     // declared standard uncertainty, in the channel's unit
};

// Settings by role, in the order of DeviceRole.
struct MotionSettings {
  std::vector<AxisDescription> axes;
};
struct LengthSettings {
  Channel channel;              // x_mm
  double u_length_nm = 0;       // declared standard uncertainty of one reading
  double u_drift_nm_per_h = 0;  // ... of its steady drift since the zero
  double u_drift_nm_per_k = 0;  // ... of its drift with the temperature of drift_channel since then
  Channel drift_channel{};      // t04_degC; no symbol: none
  // Rotations that the same instrument gives: a plate under three sensors.
  std::vector<AngleDescription> angles = {};
};
struct AngleSettings {
  std::vector<AngleDescription> angles;
  double range_arcsec = 400;  // of the instrument on either side: the field of an autocollimator
};
struct TemperatureSettings {
  std::vector<ProbeDescription> probes;
};
struct ForceSettings {
  std::vector<QuantityDescription> quantities;
};
struct EnvironmentSettings {
  std::vector<QuantityDescription> quantities;
};
struct StabiliserSettings {};  // its channels are named after its id
struct LoadSettings {
  Channel force;  // force_N
};
struct ProbeSettings {};   // of a touch probe
struct SupplySettings {};  // its channels are named after its id

using RoleSettings = std::variant<MotionSettings, LengthSettings, AngleSettings,
                                  TemperatureSettings, ForceSettings, EnvironmentSettings,
                                  StabiliserSettings, LoadSettings, ProbeSettings, SupplySettings>;
RoleSettings settings_for(DeviceRole role);  // the role's, with nothing in them

struct DeviceDescription {
  std::string id;            // "axis", "scanner", "laser-x", "support": unique in the cell
  std::string kind;          // "pi-gcs": the id of a DeviceKind
  std::string address;       // "127.0.0.1:50000"
  bool on_loopback() const;  // 127.0.0.0/8, localhost, [::1]
  std::string identity;      // what it says of itself must contain this; empty: not declared
  double timeout_s = 1.0;    // of one exchange, cell time; never below 250 ms of wall time
  double period_s = 0.0;     // slow devices: the recorder reads them every period, run or no run
  double max_age_s = 15.0;   // older values do not join a point and make a target stale

  RoleSettings settings = StabiliserSettings{};
  VoltageSensors voltages = {};   // of a device that measures by voltages
  std::vector<Channel> channels;  // those that the settings name or that the kind always gives
  // What the protocol leaves open (unit, word order, terminator, averaging, ...), by the driver's
  // own names. The driver checks names and values and answers invalid_argument naming them.
  std::map<std::string, std::string> options;

  // The role's settings, to be filled in. Gives the device that role unless it has it.
  template <class Settings>
  Settings& become() {
    auto* present = std::get_if<Settings>(&settings);
    return present ? *present : settings.emplace<Settings>();
  }
  DeviceRole role() const { return static_cast<DeviceRole>(settings.index()); }
  // Of the role's settings; empty or nullptr for every other role.
  const std::vector<AxisDescription>& axes() const;
  const std::vector<AngleDescription>& angles() const;
  const std::vector<ProbeDescription>& probes() const;
  const std::vector<QuantityDescription>& quantities() const;
  const LengthSettings* length() const { return std::get_if<LengthSettings>(&settings); }
  const Channel* force() const;  // of a load actuator
};

// The id with '-' as '_': "support-x" gives support_x_degC.
std::string symbol_from_id(std::string_view id);

}  // namespace driftwise
