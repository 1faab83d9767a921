#pragma once
// A robot of one axis, an interferometer, five thermometers and a stabiliser, in memory, behind
// the ports. No physics to speak of: a scale, a zero, a linear warming, seeded noise, and a switch
// for everything that can go wrong.
//
// Plain data, so that it can lie in memory that survives the killing of a process, as the real
// world does.

#include <cstdint>
#include <memory>

#include "server/application/cell/cell.h"
#include "tests/support/virtual_time.h"

namespace driftwise::tests {

struct SmallWorld {
  // The axis. Positions in mm on the real scale; the readback adds what the last homing put there.
  double from_mm = 0.4, to_mm = 0.4;
  std::int64_t move_begin_ns = 0, move_end_ns = 0;
  bool referenced = false, halted = false;
  bool servo_on = true;          // false: switched off at the controller; homing switches it on
  bool limit_switch = false;     // the next move is ended by the controller half-way
  bool halted_at_limit = false;  // the last one was
  double reference_mm = 0;       // error of the last reference run
  double holding_nm = 8;         // sd of the readback
  double homing_nm = 15;         // sd of the reference
  // The interferometer.
  double zero_mm = 0.123;
  double noise_nm = 1.5;
  bool beam_lost = false;
  double laser_clock_jump_s = 0;  // the adapter's clock is set by this before its next reading
  double laser_clock_s = 0;       // ... and stands so far from cell time since
  int laser_clock_jumps = 0;
  int disturbed_readings = 0;  // the next n readings jump about by ...
  double disturbance_nm = 60;
  // Temperatures: t0n = 20 + n / 10 + warming * hours. The robot grows by nm_per_k of t01's
  // warming.
  double warming_k_per_h = 0.5, nm_per_k = 150;
  double play_nm = 0;          // the end-effector lags behind the axis by half of it, either way
  bool came_down = false;      // the last move of more than 100 nm
  double bend_nm_per_mm2 = 0;  // the end-effector runs ahead of the scale by this times q^2
  double support_degc = 23.0, support_set_degc = 23.0;
  double force_n = 0;                 // what hangs there
  std::int64_t load_rests_at_ns = 0;  // weights move until then
  int loads = 0;                      // changes of the force by the actuator
  bool probe_broken = false;          // t03 gives no value
  // Away: every call fails with unavailable.
  bool axis_away = false, laser_away = false, scanner_away = false, support_away = false,
       load_away = false;
  bool laser_mute = false;         // it says who it is, and gives no reading
  bool cut = false;                // every exchange is cut off, as at the end of the daemon
  bool load_jammed = false;        // the weights stick: the actuator refuses to change them
  bool creeping = false;           // the axis never becomes quiet
  bool stop_does_nothing = false;  // the controller acknowledges a stop and moves on
  // What was done.
  int moves = 0, homes = 0, zeroings = 0, stops = 0, scans = 0, readings = 0;
  int axis_calls = 0,
      first_stop_call = 0;  // calls of the controller; which of them the first stop was
  double furthest_mm = 0;   // the largest |q| ever commanded
  bool jumped = false;      // a length jumped once, as a test wanted it
  // What an outside watcher was told.
  std::int64_t told_accepted = 0;
  std::uint64_t random_state = 0x9e3779b97f4a7c15;

  double gauss();
};

CellDescription small_cell(const std::string& database);
// The same with [load] up to 4 N, changed by an actuator or by a person.
CellDescription small_cell_with_load(const std::string& database, bool actuator);
// The devices look at the world and the time, both of which outlive them. The interferometer may
// be described as an autocollimator: the axis then turns the end-effector by 10 arcsec per mm.
application::Devices small_devices(SmallWorld& world, VirtualTime& time,
                                   const CellDescription& cell);

}  // namespace driftwise::tests
