#pragma once
// Data sets with effects hidden in them, made without any code of the effects, the regression or
// the plant: a linear axis and a three-axis robot in a room, integrated in one-second steps, with
// noise of a known shape.
//
// The size of what is hidden is given as chi2 = sum (v - P v)^2 / sigma^2 over the calibration
// rows, all outputs together: what it leaves beyond the baseline, whitened by the noise (the
// statistical contract).

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "server/core/data/dataset.h"

namespace driftwise::hidden {

enum class Robot : std::uint8_t { linear_axis, micro_nano };

struct Hidden {
  std::string cause{};    // of the catalogue; "" for nothing; "uncatalogued:kink", ...
  double parameter = 0;   // tau_s, width_nm, period_nm, time_s as the cause has it
  double chi2 = 100;      // sensor_fault, outliers, noise_change: ignored
  std::string subject{};  // what it is about, filled in by make(): "t07"
};

struct World {
  Robot robot = Robot::linear_axis;
  double noise_nm = 5;         // of a point
  double autocorrelation = 0;  // of the slow part from one calibration row to the next
  double slow_share = 0.5;     // of the variance, when autocorrelation is not 0
  bool two_times = false;      // half of the slow part five times as slow: no model has that
  // Real robots stand a little off the places they are sent to, evenly within this; and it is the
  // instruments that have the noise. false: the motors' readings have it.
  double hold_nm = 0;
  bool noise_in_pose = false;
};

struct HiddenData {
  Dataset data;
  std::string baseline;  // formula
  std::vector<Hidden> hidden;
  Eigen::MatrixXd effect_nm;             // rows x outputs: what was hidden
  Eigen::MatrixXd covariance;            // of one output's noise at the calibration rows, nm^2
  std::vector<std::size_t> calibration;  // rows
};

HiddenData make(const World& world, const std::vector<Hidden>& hidden, std::uint64_t seed);

// Causes that make() can hide on a robot, with a parameter drawn for this seed; those that have a
// strength, those that have none (faults of the data), and what is in no catalogue.
std::vector<Hidden> hideable(Robot robot, std::uint64_t seed);
std::vector<Hidden> faults();
std::vector<Hidden> uncatalogued();

}  // namespace driftwise::hidden
