#pragma once
// One measuring computer's world, as cell.toml describes it. Text form: docs/cell-file.md; parsed
// in server/formats/cell_file. Plain data: the same for every room.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "server/core/cell_time.h"
#include "server/core/channel.h"

namespace driftwise {

struct ClockDescription {
  CellTime
      epoch;  // at this instant of wall time cell time equals wall time (when speed is 1: unused)
  double speed = 1.0;  // cell seconds per wall second; other than 1 only with loopback devices
  std::string file;    // where the present speed is shared with a simulated cell; empty: none
};

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

struct DeviceDescription {
  std::string id;       // "axis", "scanner", "laser-x", "support": unique in the cell
  std::string kind;     // "pi-gcs", "keithley-2701", "interferometer-adapter", "watlow-ez-zone"
  std::string address;  // "127.0.0.1:50000"
  bool on_loopback() const;  // 127.0.0.0/8, localhost, [::1]
  double timeout_s = 1.0;    // of one exchange, cell time; never below 250 ms of wall time
  double period_s = 0.0;     // slow devices: the recorder reads them every period, run or no run
  double max_age_s = 15.0;   // older values do not join a point and make a target stale

  std::vector<AxisDescription> axes;     // motion controllers
  std::vector<ProbeDescription> probes;  // scanners
  std::optional<Channel> length;         // interferometers: x_mm
  double u_length_nm = 0;                // ... declared standard uncertainty
  // What the protocol leaves open (unit, word order, terminator, averaging, ...), by the driver's
  // own names. The driver checks names and values and answers invalid_argument naming them.
  std::map<std::string, std::string> options;
};

struct RunRules {  // [run]; a run may override them, the run's record keeps what was used
  int readings_per_point = 4;
  double max_spread_nm = 5.0;  // standard deviation of a point's readings
  int max_rereads = 2;         // failed gate: read again without moving ...
  int max_reapproaches = 1;    // ... then move away and come again ...
  int max_requeues = 1;        // ... then again at the end of the line; then the point is given up
  double reapproach_mm = 0.1;  // how far away, towards the zero
  double settle_s = 2.0;       // quiet time after in-position
  double in_position_nm = 150.0;  // read back against commanded
  double quiet_nm = 60.0;         // peak to peak of the readback over settle_s
  double move_timeout_s = 30.0;
  double max_temperature_age_s = 15.0;  // join by device time stamps
};

struct StartChecks {  // [checks]
  double stabiliser_band_k = 0.01;
  double stabiliser_wait_s = 3600.0;   // how long the start may wait for it
  double max_drift_nm_per_min = 60.0;  // of the zero at rest
  double drift_window_s = 60.0;
};

struct ServingRules {  // [serving]
  double rebuild_period_s = 5.0;
  bool refuse_stale = false;
  bool refuse_outside_domain = false;
  double max_age_s = 60.0;  // older than this a temperature is stale
};

struct CellDescription {
  std::string name;
  std::string database;  // path; the parser makes it absolute, relative to the cell file
  std::string listen = "127.0.0.1:50051";  // gRPC; port 0 picks a free one
  std::string target_line = "";            // text target service, "host:port"; empty: off
  std::string http = "";                   // /healthz and /metrics, "host:port"; empty: off
  ClockDescription clock;
  std::vector<DeviceDescription> devices;
  RunRules run;
  StartChecks checks;
  ServingRules serving;
  std::string text;  // the file as read
  std::string hash;  // of the text: stored with every run

  std::vector<Channel> motor_channels() const;        // q1_mm.., in order of devices and axes
  std::vector<Channel> length_channels() const;       // x_mm ..
  std::vector<Channel> temperature_channels() const;  // probes, in order
  const DeviceDescription* find_device(const std::string& id) const;
  const AxisDescription* find_axis(const std::string& channel_name) const;
};

}  // namespace driftwise
