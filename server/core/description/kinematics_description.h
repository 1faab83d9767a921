#pragma once
// What a robot's drawing says about its geometry: nominal lengths and angles, as the [kinematics]
// section of cell.toml or a robot file gives them (docs/kinematics.md). Plain data: the same for
// every room; server/kinematics makes a mechanism of it.

#include <array>
#include <limits>
#include <string>
#include <vector>

#include "server/core/channel.h"

namespace driftwise {

// Where the robot stands in the measuring frame: p_measured = Rz Ry Rx p_robot + (x, y, z).
struct FrameDescription {
  double x_mm = 0, y_mm = 0, z_mm = 0;
  double rx_deg = 0, ry_deg = 0, rz_deg = 0;
};

// One branch of a delta with linear axes: a carriage that moves along the axis carries an arm whose
// other end holds the platform.
struct DeltaBranch {
  Channel motor;           // q1_mm
  double azimuth_deg = 0;  // of the carriage seen from the centre, from x towards y
  double radius_mm = 0;    // horizontal distance, carriage joint to platform joint, at pose zero
  double length_mm = 0;    // of the arm, joint to joint
  double offset_mm = 0;    // what the scale reads when the carriage is where it should read zero
  double tilt_radial_deg = 0, tilt_tangential_deg = 0;  // of the axis from the vertical
  double scale_ppm = 0;                                 // the scale reads this much too much
};

// Errors of a joint beyond the drawing; all 0 as drawn. Each turns the joint forwards.
struct JointErrors {
  // Sag: in the direction of gravity's torque, per metre of lever; per newton metre where the links
  // have masses.
  double sag_urad_per_m = 0, sag_urad_per_newton_m = 0;
  double play_arcsec = 0;  // from one flank to the other; gravity says which one
  double gear_cos1_arcsec = 0, gear_sin1_arcsec = 0;  // once per turn of the joint
  double gear_cos2_arcsec = 0, gear_sin2_arcsec = 0;  // twice per turn
  Channel drift_channel;                              // t04_degC; without symbol: no drift
  double drift_arcsec_per_k = 0, drift_from_degC = 20;

  bool operator==(const JointErrors&) const = default;
};

// One link of a serial arm, after Denavit and Hartenberg: Rz(theta + q) Tz(d) Tx(a) Rx(alpha), and
// after Hayati Ry(beta) behind it where the next axis is nearly parallel.
struct ArmLink {
  Channel motor;  // q1_rad
  double theta_deg = 0, d_mm = 0, a_mm = 0, alpha_deg = 0, beta_deg = 0;
  double mass_kg = 0;                         // 0 in all links: unknown
  std::array<double, 3> mass_centre_mm = {};  // in the frame behind the link
  JointErrors errors{};
  // Of the angle as read back, degrees; infinite: none declared.
  double min_deg = -std::numeric_limits<double>::infinity();
  double max_deg = std::numeric_limits<double>::infinity();
};

struct LinearAxis {
  Channel motor;  // q1_mm
  Channel pose;   // x_mm
  double offset_mm = 0, scale_ppm = 0;
};

struct KinematicsDescription {
  std::string kind;                   // "delta-vertical", "serial-arm", "linear-axis"
  bool carriages_above = true;        // delta: the carriages stand above the platform
  std::vector<DeltaBranch> branches;  // delta: three
  std::vector<ArmLink> links;         // arm: from the base on
  double tool_x_mm = 0, tool_y_mm = 0, tool_z_mm = 0;  // arm: the measured point in the flange
  double tool_mass_kg = 0;                             // arm: at the measured point
  std::array<double, 3> gravity = {0, 0, -1};          // arm: direction, in the robot's base
  std::vector<LinearAxis> axes;                        // linear-axis: one
  FrameDescription frame;
  std::vector<std::string> hold;  // parameters kept at their nominal value: "branch1.scale_ppm",
                                  // "frame.*", "*.beta_deg"
};

}  // namespace driftwise
