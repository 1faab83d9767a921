#include "tests/hidden_effects/foreign/shapes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/hidden_effects/foreign/constants.h"

namespace driftwise::foreign {

using Eigen::VectorXd;

namespace {

// Walks the moves up to each row and asks for the state there.
template <class OnMove, class AtRow>
VectorXd walk(const Campaign& campaign, OnMove on_move, AtRow at_row) {
  VectorXd out(campaign.rows());
  std::size_t next = 0;
  for (int i = 0; i < campaign.rows(); ++i) {
    while (next < campaign.moves.size() && campaign.moves[next].end_s <= campaign.time_s[i]) {
      on_move(campaign.moves[next++]);
    }
    out[i] = at_row(i);
  }
  return out;
}

}  // namespace

VectorXd at_rows(const Campaign& campaign, const Eigen::Ref<const VectorXd>& series) {
  VectorXd out(campaign.rows());
  for (int i = 0; i < campaign.rows(); ++i) {
    out[i] = campaign.room.at(series, campaign.time_s[i]);
  }
  return out;
}

VectorXd lag_shape(const Campaign& campaign, int sensor, double tau_s) {
  return at_rows(campaign, campaign.room.lagged(campaign.room.body.col(sensor), tau_s));
}

VectorXd rate_shape(const Campaign& campaign, int sensor, double span_s) {
  const auto body = campaign.room.body.col(sensor);
  VectorXd out(campaign.rows());
  for (int i = 0; i < campaign.rows(); ++i) {
    const double t = campaign.time_s[i];
    const double before = std::max(0.0, t - span_s);
    const double after =
        std::min(t + span_s, campaign.room.step_s * static_cast<double>(body.size() - 1));
    out[i] = (campaign.room.at(body, after) - campaign.room.at(body, before)) / (after - before) *
             3600.0;
  }
  return out;
}

VectorXd motor_heat_shape(const Campaign& campaign, int motor, double tau_s) {
  return at_rows(campaign, campaign.room.lagged(campaign.room.motion.col(motor), tau_s) * 1.0);
}

VectorXd activity_heat_shape(const Campaign& campaign, double tau_s, double power) {
  const VectorXd heat = campaign.room.activity.array().pow(power);
  VectorXd cold = campaign.room.lagged(heat, tau_s);
  return at_rows(campaign, cold);
}

VectorXd play_shape(const Campaign& campaign, int motor, double width) {
  const double half = 0.5 * width / campaign.robot.motor_half[motor];
  double held = 0.0;
  const double scale = campaign.robot.motor_half[motor];
  return walk(
      campaign,
      [&](const Move& move) {
        held = std::clamp(held + move.to[motor] - move.from[motor], -half, half);
      },
      [&](int) { return held * scale; });
}

VectorXd friction_shape(const Campaign& campaign, int coordinate, double slide) {
  // dF/dx = (1 - F sign(dx)) / slide, solved over each straight move.
  double force = 0.0;
  return walk(
      campaign,
      [&](const Move& move) {
        const double step = move.to[coordinate] - move.from[coordinate];
        if (step != 0.0) {
          const double way = step > 0.0 ? 1.0 : -1.0;
          force = way + (force - way) * std::exp(-std::abs(step) / slide);
        }
      },
      [&](int) { return force; });
}

VectorXd creep_shape(const Campaign& campaign, int motor, double tau_s) {
  double state = 0.0;
  double at_s = 0.0;
  return walk(
      campaign,
      [&](const Move& move) {
        state = state * std::exp(-(move.end_s - at_s) / tau_s) + move.to[motor] - move.from[motor];
        at_s = move.end_s;
      },
      [&](int i) { return state * std::exp(-(campaign.time_s[i] - at_s) / tau_s); });
}

VectorXd air_shape(const Campaign& campaign) {
  VectorXd out(campaign.rows());
  for (int i = 0; i < campaign.rows(); ++i) {
    const double pressure_pa = 100.0 * campaign.pressure_hpa[i];
    const double t = campaign.air_degc[i];
    const double dry = 2.8793e-9 * pressure_pa / (1.0 + 0.003671 * t) * 1.0e6;
    const double vapour_pa =
        campaign.humidity_pct[i] / 100.0 * 611.2 * std::exp(17.62 * t / (243.12 + t));
    out[i] = dry - 3.7e-10 * vapour_pa * 1.0e6;
  }
  return out.array() - out[0];
}

VectorXd abbe_shape(const Campaign& campaign, int direction, int arm) {
  // d = theta x a: the component along `direction` of the rotation about the third axis.
  const int about = 3 - direction - arm;
  const double sign = (direction + 1) % 3 == about ? 1.0 : -1.0;
  return sign * kRadPerArcsec * campaign.tilt.col(about);
}

VectorXd cosine_shape(const Campaign& campaign, int coordinate, int tilt, double angle_rad) {
  const Eigen::MatrixXd u = campaign.clean_u();
  VectorXd out(campaign.rows());
  for (int i = 0; i < campaign.rows(); ++i) {
    const double length = campaign.robot.pose_value(coordinate, u(i, coordinate));
    const double theta = kRadPerArcsec * campaign.tilt(i, tilt);
    out[i] = length * (std::cos(theta + angle_rad) - std::cos(angle_rad));
  }
  return out;
}

int direction_of(const std::string& pose) {
  return pose == "x" ? 0 : pose == "y" ? 1 : pose == "z" ? 2 : -1;
}

}  // namespace driftwise::foreign
