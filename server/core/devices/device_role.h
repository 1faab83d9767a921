#pragma once
// Roles of devices: what a device is to the cell, whoever made it. Every rule of the daemon that
// depends on a device asks its role.

#include <string_view>

namespace driftwise {

// In this order devices are prepared for a run and shown.
enum class DeviceRole {
  motion,       // moves the axes of a robot and reads them back
  length,       // measures a length of the pose
  angle,        // measures rotations of the pose
  temperature,  // measures the structure's temperatures: each one belongs to every point
  force,        // measures forces
  environment,  // measures the air: temperature, pressure, humidity
  stabiliser,   // holds a temperature by a loop of its own
  load,         // applies a known force to the end-effector
  probe,        // touches a surface and says when
  supply,       // feeds the cell: mains and battery. It joins no point; holds look at it
};

constexpr std::string_view role_name(DeviceRole role) {
  switch (role) {
    case DeviceRole::motion:
      return "motion";
    case DeviceRole::length:
      return "length";
    case DeviceRole::angle:
      return "angle";
    case DeviceRole::temperature:
      return "temperature";
    case DeviceRole::force:
      return "force";
    case DeviceRole::environment:
      return "environment";
    case DeviceRole::stabiliser:
      return "stabiliser";
    case DeviceRole::load:
      return "load";
    case DeviceRole::probe:
      return "probe";
    case DeviceRole::supply:
      return "supply";
  }
  return "?";
}

// Its readings together are a pose.
constexpr bool measures_pose(DeviceRole role) {
  return role == DeviceRole::length || role == DeviceRole::angle;
}

// A run reads it itself while it is under way, and between runs it is read in any case.
constexpr bool is_read_by_runs(DeviceRole role) {
  return role == DeviceRole::motion || measures_pose(role);
}

// Its channels join a point where they are fresh enough; without them the point stands.
constexpr bool joins_when_fresh(DeviceRole role) {
  return role == DeviceRole::stabiliser || role == DeviceRole::environment ||
         role == DeviceRole::force;
}

}  // namespace driftwise
