#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "tests/hidden_effects/foreign/random.h"

namespace driftwise::foreign {

// One move of the robot, in normalised motor coordinates, straight from one place to the next.
struct Move {
  double begin_s = 0.0;
  double end_s = 0.0;
  Eigen::VectorXd from;
  Eigen::VectorXd to;
};

// Thermometer: a lump of the machine between room air, motor heat and a sensed activity.
struct Thermometer {
  std::string name;
  std::string part;
  double tau_s = 1000.0;
  double air_share = 1.0;
  double motor_k = 0.0;
  double activity_k = 0.0;
  double offset_k = 0.0;
  double noise_k = 0.0;
  double quantum_k = 0.0;
  double filter_s = 0.0;
};

// Slow quantities on an even grid of time that starts with the first row.
struct RoomTrace {
  double step_s = 1.0;
  Eigen::VectorXd air_degc;
  Eigen::VectorXd pressure_hpa;
  Eigen::VectorXd humidity_pct;
  // Mean of |ds/dt| per motor in each step, 1/s.
  Eigen::MatrixXd motion;
  Eigen::VectorXd activity;
  // Bodies under the thermometers, degC.
  Eigen::MatrixXd body;
  // What the thermometer's filter passes on, degC.
  Eigen::MatrixXd sensed;

  double at(const Eigen::Ref<const Eigen::VectorXd>& series, double time_s) const;
  // First-order lag of a series, begun in its steady state.
  Eigen::VectorXd lagged(const Eigen::Ref<const Eigen::VectorXd>& series, double tau_s) const;
};

struct ActivityChange {
  double time_s = 0.0;
  double level = 0.0;
};

// Adds the way of the motors in each step of the trace to `room.motion`.
void spread_motion(RoomTrace& room, const std::vector<Move>& moves);

RoomTrace make_room(double duration_s, int motors, const std::vector<Move>& moves,
                    const std::vector<ActivityChange>& activity,
                    const std::vector<Thermometer>& thermometers, Random& random);

}  // namespace driftwise::foreign
