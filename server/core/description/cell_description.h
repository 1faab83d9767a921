#pragma once
// One measuring computer's world, as cell.toml describes it. Text form: docs/cell-file.md; parsed
// in server/formats/cell_file. Plain data: the same for every room.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/core/cell_time.h"
#include "server/core/channel.h"
#include "server/core/description/access_description.h"
#include "server/core/description/backup_rules.h"
#include "server/core/description/certificate_description.h"
#include "server/core/description/hold_rule.h"
#include "server/core/description/keep_out_description.h"
#include "server/core/description/kinematics_description.h"
#include "server/core/description/notify_description.h"
#include "server/core/description/plausibility_description.h"
#include "server/core/description/setup_description.h"
#include "server/core/description/thinning_rules.h"
#include "server/core/devices/device_kind.h"

namespace driftwise {

// One kinematic structure of the cell: [[robot]]. A file without [[robot]] describes one, without
// id.
struct RobotDescription {
  std::string id;             // "ma"; empty: the cell's only robot, its names carry no id
  std::string controller;     // id of the device that moves it; its role is motion
  std::vector<Channel> axes;  // those of the controller that are this robot's, in order
  std::string tool;           // what is mounted on its end-effector; empty: not said
  std::optional<KinematicsDescription> kinematics;  // nominal geometry; none: an unknown robot
};

struct ClockDescription {
  CellTime
      epoch;  // at this instant of wall time cell time equals wall time (when speed is 1: unused)
  double speed = 1.0;  // cell seconds per wall second; other than 1 only with loopback devices
  std::string file;    // where the present speed is shared with a simulated cell; empty: none
};

// What raw readings need to become a pose (server/correction). With it the lengths of the devices
// are paths along beams, x_path_mm, and x_mm is the corrected pose.
struct BeamDescription {
  Channel length;  // x_mm: the interferometer whose beam this is
  // Where the beam meets its mirror, from the centre of rotation, at pose zero and per mm of pose:
  // a beam fixed in the room before a mirror that moves sideways has -1 on that side.
  std::array<double, 3> offset_mm{}, offset_per_mm{};
  double u_offset_mm = 0;  // standard uncertainty of each component that matters
  // Small rotation, about x, y, z, from the axis to the direction along which this interferometer
  // measures: what squaring the mirrors left.
  std::array<double, 3> direction_arcsec{};
  double u_direction_arcsec = 0;
  double u_flatness_nm = 0;  // of its mirror, over the workspace
};

struct CorrectionDescription {
  bool cosine = false;
  std::vector<BeamDescription> beams;  // at most one per length; a length without: no Abbe term
};

// Force on the end-effector, by an actuator or by known weights that a person hangs.
struct LoadDescription {
  double max_n = 0;               // soft limit: nobody asks for more
  double u_n = 0;                 // declared standard uncertainty of what hangs
  double gravity_m_s2 = 9.80665;  // turns newtons into the grams a person looks for
};

struct RunRules {  // [run]; a run may override them, the run's record keeps what was used
  int readings_per_point = 4;
  // Standard deviation of a point's readings: lengths, and rotations.
  double max_spread_nm = 5.0;
  double max_spread_arcsec = 0.2;  // ten times the resolution of the study's autocollimators
  int max_rereads = 2;             // failed gate: read again without moving ...
  int max_reapproaches = 1;        // ... then move away and come again ...
  int max_requeues = 1;        // ... then again at the end of the line; then the point is given up
  double reapproach_mm = 0.1;  // how far away, towards the zero
  double settle_s = 2.0;       // quiet time after in-position
  double in_position_nm = 150.0;  // read back against commanded
  double quiet_nm = 60.0;         // peak to peak of the readback over settle_s
  double move_timeout_s = 30.0;
  double max_temperature_age_s = 15.0;  // join by device time stamps
  // The run is paused when more than this share of the rows that were decided since its start, or
  // since the last such pause, was given up, and at least kLeastGivenUp of them; 1: never.
  double max_given_up_share = 0.2;
  static constexpr int kLeastGivenUp = 5;
  // When the run ends as done: the force is taken off and the axes return to zero.
  bool park = true;
};

enum class AfterAway { go_on, wait };  // "go-on": by itself; "wait": a person resumes the run

// What a run does that was under way when the daemon ended.
struct RestartRules {  // [run]
  // Only the daemon was away, the controller has kept its reference.
  AfterAway after_restart = AfterAway::go_on;
  // The computer was started anew, or the controller has lost its reference: an unexpected start
  // must be chosen.
  AfterAway after_power_loss = AfterAway::wait;
};

struct StartChecks {  // [checks]
  double stabiliser_band_k = 0.01;
  double stabiliser_wait_s = 3600.0;   // how long the start may wait for it
  bool hold_on_stabilisers = true;     // outside the band a run waits: a HoldRule for each of them
  double max_drift_nm_per_min = 60.0;  // of the zero at rest
  double drift_window_s = 60.0;
};

struct ServingRules {  // [serving]
  double rebuild_period_s = 5.0;
  bool refuse_stale = false;
  bool refuse_outside_domain = false;
  bool refuse_outside_limits = true;  // beyond the axes' soft limits
  double max_age_s = 60.0;            // older than this a temperature is stale
};

struct CellDescription {
  std::string name;
  std::string database;  // path; the parser makes it absolute, relative to the cell file
  std::string listen = "127.0.0.1:50051";  // gRPC; port 0 picks a free one
  std::string target_line = "";            // text target service, "host:port"; empty: off
  std::string http = "";                   // /healthz and /metrics, "host:port"; empty: off
  AccessDescription access;                // who may reach the daemon, and by which further doors
  ClockDescription clock;
  std::vector<RobotDescription> robots;       // as the file names them
  std::vector<KeepOutDescription> keep_outs;  // [[keep_out]]: distances between robots
  std::vector<DeviceDescription> devices;
  std::vector<SetupDescription> setups;  // [[setup]]; empty: every run reads every instrument
  // Kinds that the file was read with: texts of the same cell that are stored are read with them.
  // They outlive this.
  DeviceKinds kinds;
  RunRules run;
  RestartRules restart;
  StartChecks checks;
  PlausibilityRules plausibility;
  std::vector<HoldRule> holds;  // of the file, then those of the stabilisers; names are unique
  ServingRules serving;
  BackupRules backup;
  ThinningRules thinning;
  std::vector<ReceiverDescription> receivers;  // [[notify]]
  WatchdogRules watchdog;
  std::vector<ChannelAlarmDescription> channel_alarms;
  std::vector<CertificateDescription> certificates;  // [[certificate]]
  std::optional<CorrectionDescription> correction;
  std::optional<LoadDescription> load;  // none: the cell knows no force
  // Nominal geometry of the first robot; none: an unknown robot.
  std::optional<KinematicsDescription> kinematics;
  std::string text;  // the file as read
  std::string hash;  // of the text: stored with every run

  // More than one: names of motor and pose channels carry the robot's id.
  bool has_several_robots() const { return robots.size() > 1; }
  const RobotDescription* find_robot(std::string_view id) const;
  std::vector<AxisDescription> axes() const;     // in order of devices
  std::vector<Channel> motor_channels() const;   // q1_mm.., those of axes()
  std::vector<Channel> length_channels() const;  // x_mm .. : pose coordinates
  // What the interferometers themselves give, same order: x_path_mm .. with [correction], else the
  // lengths.
  std::vector<Channel> path_channels() const;
  std::vector<Channel> angle_channels() const;        // rx_arcsec ..
  std::optional<Channel> force_channel() const;       // force_N in a cell with [load]
  std::vector<Channel> temperature_channels() const;  // probes, in order
  const DeviceDescription* find_device(const std::string& id) const;
  const AxisDescription* find_axis(const std::string& channel_name) const;
  const DeviceDescription* load_actuator() const;  // nullptr: an operator changes the force
};

}  // namespace driftwise
