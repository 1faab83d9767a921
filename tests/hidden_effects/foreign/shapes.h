#pragma once

#include <Eigen/Core>

#include "tests/hidden_effects/foreign/campaign.h"

namespace driftwise::foreign {

// Shapes over the measured rows that mechanisms and their rivals are made of.

// Series of the room at the rows.
Eigen::VectorXd at_rows(const Campaign& campaign, const Eigen::Ref<const Eigen::VectorXd>& series);
// Thermometer body behind a further lag, K.
Eigen::VectorXd lag_shape(const Campaign& campaign, int sensor, double tau_s);
// Rate of a thermometer body over about `span_s`, K/h.
Eigen::VectorXd rate_shape(const Campaign& campaign, int sensor, double span_s);
// Body heated by the work of one motor, losing heat with tau; unit power.
Eigen::VectorXd motor_heat_shape(const Campaign& campaign, int motor, double tau_s);
// Body heated by the sensed activity to some power.
Eigen::VectorXd activity_heat_shape(const Campaign& campaign, double tau_s, double power);
// Play of a motor: the part of its path that friction holds back, -width/2 .. width/2 (unit of
// width).
Eigen::VectorXd play_shape(const Campaign& campaign, int motor, double width);
// Dry friction in pose coordinate j: like play, with an elastic approach (Dahl's model).
Eigen::VectorXd friction_shape(const Campaign& campaign, int coordinate, double slide);
// Relaxation after moves of one motor: each move adds its length, decaying with tau.
Eigen::VectorXd creep_shape(const Campaign& campaign, int motor, double tau_s);
// Refractivity of air relative to the first row, ppm. Source: Edlen's formula, simplified (Birch,
// Downs 1993).
Eigen::VectorXd air_shape(const Campaign& campaign);
// Lever arm shape of pose coordinate x, y or z: rotations in rad, for lever along `arm` (0..2).
Eigen::VectorXd abbe_shape(const Campaign& campaign, int direction, int arm);
// Length along direction times (cos(tilt + angle) - cos(angle)), unit of the length.
Eigen::VectorXd cosine_shape(const Campaign& campaign, int coordinate, int tilt, double angle_rad);
// x -> 0, y -> 1, z -> 2, else -1.
int direction_of(const std::string& pose);

}  // namespace driftwise::foreign
