#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "tests/hidden_effects/foreign/constants.h"
#include "tests/hidden_effects/foreign/hidden.h"
#include "tests/hidden_effects/foreign/shapes.h"

namespace driftwise::foreign {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// A smooth random wave of the place: -1 .. 1, about one and a half periods over the stroke.
VectorXd place_wave(const MatrixXd& u, Random& random) {
  VectorXd wave(u.rows());
  std::vector<double> k;
  for (Eigen::Index j = 0; j < u.cols(); ++j) {
    k.push_back(random.uniform(0.6, 1.0) * random.sign());
  }
  const double phase = random.uniform(0.0, kTurn);
  for (Eigen::Index i = 0; i < u.rows(); ++i) {
    double sum = phase;
    for (Eigen::Index j = 0; j < u.cols(); ++j) {
      sum += 0.75 * kTurn * k[static_cast<std::size_t>(j)] * u(i, j) /
             std::sqrt(static_cast<double>(u.cols()));
    }
    wave[i] = std::sin(sum);
  }
  return wave;
}

VectorXd time_wave(const Campaign& campaign, double turns, Random& random) {
  const double phase = random.uniform(0.0, kTurn);
  return (kTurn * turns / campaign.time_s[campaign.rows() - 1] * campaign.time_s.array() + phase)
      .sin();
}

VectorXd signs(const VectorXd& wave) {
  return wave.unaryExpr([](double value) { return value >= 0.0 ? 1.0 : -1.0; });
}

VectorXd first_motor_sides(const Campaign& campaign, int motor) {
  return play_shape(campaign, motor, 1e-4 * campaign.robot.motor_half[motor]) /
         (0.5e-4 * campaign.robot.motor_half[motor]);
}

VectorXd thermal_stick(const Campaign& campaign, int sensor) {
  // A bolted joint holds until the strain overcomes friction: play of the temperature.
  const VectorXd series = campaign.body.col(sensor);
  const double width = 0.35 * (series.maxCoeff() - series.minCoeff());
  double held = 0.0;
  VectorXd shape(series.size());
  for (Eigen::Index i = 0; i < series.size(); ++i) {
    held = i == 0 ? 0.0 : std::clamp(held + series[i] - series[i - 1], -0.5 * width, 0.5 * width);
    // It slips in lumps.
    shape[i] = std::round(held / width * 4.0) / 4.0;
  }
  return shape;
}

VectorXd shape_of(const std::string& id, const Campaign& campaign, Random& random) {
  const MatrixXd u = campaign.clean_u();
  const int rows = campaign.rows();
  const double duration_s = campaign.time_s[rows - 1];
  const int motor = random.below(campaign.robot.axes);
  const VectorXd part = campaign.time_s / duration_s;
  if (id == "chirp_by_place") {
    const double turns = random.uniform(2.0, 5.0);
    const VectorXd chirp = (kTurn * turns * part.array() * (1.0 + 1.5 * part.array())).sin();
    return chirp.cwiseProduct(signs(place_wave(u, random)));
  }
  if (id == "place_by_time") {
    return place_wave(u, random).cwiseProduct(
        time_wave(campaign, random.uniform(2.0, 5.0), random));
  }
  if (id == "temperature_product") {
    const int count = campaign.thermometer_count();
    const int a = random.below(count);
    const int b = (a + 1 + random.below(count - 1)) % count;
    const VectorXd first = campaign.body.col(a).array() - campaign.body.col(a).mean();
    const VectorXd second = campaign.body.col(b).array() - campaign.body.col(b).mean();
    return first.cwiseProduct(second) / std::max(1e-6, first.norm() * second.norm() / rows);
  }
  if (id == "thermal_stick") {
    return thermal_stick(campaign, random.below(campaign.thermometer_count()));
  }
  if (id == "backlash_grows_warm") {
    const VectorXd t = campaign.body.col(random.below(campaign.thermometer_count()));
    const VectorXd warm = (t.array() - t.mean()) / std::max(1e-6, t.maxCoeff() - t.minCoeff());
    return first_motor_sides(campaign, motor).cwiseProduct(warm);
  }
  if (id == "previous_place") {
    // Memory of the place before the last: the guide keeps a dent.
    VectorXd shape = VectorXd::Zero(rows);
    for (int i = 2; i < rows; ++i) {
      shape[i] = u(i - 2, motor) * u(i, motor);
    }
    return shape;
  }
  if (id == "line_warm_in") {
    // Each line begins with an error of its own size and sign, which dies out over a few rows.
    VectorXd shape = VectorXd::Zero(rows);
    double size = 0.0;
    int since = 0;
    for (int i = 0; i < rows; ++i) {
      if (i == 0 || campaign.visits[i].line != campaign.visits[i - 1].line) {
        size = random.normal();
        since = 0;
      }
      shape[i] = size * std::exp(-since++ / 4.0);
    }
    return shape;
  }
  if (id == "beat_in_region") {
    const double turns = random.uniform(12.0, 25.0);
    const VectorXd beat =
        time_wave(campaign, turns, random) + time_wave(campaign, 1.15 * turns, random);
    const double limit = random.uniform(-0.2, 0.2);
    return beat.cwiseProduct(
        u.col(motor).unaryExpr([limit](double v) { return v > limit ? 1.0 : 0.0; }));
  }
  if (id == "bistable") {
    // A mount with two states, switching at random about fifteen times.
    VectorXd shape(rows);
    double state = 1.0;
    for (int i = 0; i < rows; ++i) {
      state = random.chance(15.0 / rows) ? -state : state;
      shape[i] = state;
    }
    return shape;
  }
  if (id == "parity_by_place") {
    const VectorXd place = signs(place_wave(u, random));
    VectorXd shape(rows);
    for (int i = 0; i < rows; ++i) {
      shape[i] = (i % 2 == 0 ? 1.0 : -1.0) * place[i];
    }
    return shape;
  }
  if (id == "force_ages") {
    const VectorXd force = campaign.force_n / std::max(1e-9, campaign.force_n.maxCoeff());
    return (force.array() - force.mean()).matrix().cwiseProduct(time_wave(campaign, 1.3, random));
  }
  // region_in_one_hour: a bump in the place, there for a sixth of the time only.
  const double begin = random.uniform(0.1, 0.7);
  const VectorXd wave = place_wave(u, random);
  VectorXd shape = VectorXd::Zero(rows);
  for (int i = 0; i < rows; ++i) {
    if (part[i] > begin && part[i] < begin + 0.17) {
      shape[i] = wave[i];
    }
  }
  return shape;
}

}  // namespace

const std::vector<std::string>& unlisted_ids() {
  static const std::vector<std::string> ids{
      "chirp_by_place",  "place_by_time",       "temperature_product",
      "thermal_stick",   "backlash_grows_warm", "previous_place",
      "line_warm_in",    "beat_in_region",      "bistable",
      "parity_by_place", "force_ages",          "region_in_one_hour"};
  return ids;
}

Needs unlisted_needs(const std::string& id) {
  Needs needs;
  needs.times = id != "previous_place" && id != "parity_by_place" && id != "backlash_grows_warm";
  needs.thermometers = id == "temperature_product"                            ? 2
                       : id == "thermal_stick" || id == "backlash_grows_warm" ? 1
                                                                              : 0;
  needs.force = id == "force_ages";
  return needs;
}

Hidden draw_unlisted(const std::string& id, const Campaign& campaign, Random& random) {
  Hidden hidden;
  hidden.cause = id;
  const VectorXd shape = shape_of(id, campaign, random);
  if (!shape.allFinite() || shape.cwiseAbs().maxCoeff() <= 0.0) {
    throw std::runtime_error("the shape is empty here");
  }
  const int j = random.below(campaign.robot.axes);
  Errors unit{campaign.no_motor_error(), campaign.no_pose_error(), {}};
  unit.dp.col(j) = shape * campaign.robot.sigma[j];
  hidden.parameters["coordinate"] = j;
  hidden.errors = [unit](double amplitude) { return Errors{unit.dq, unit.dp * amplitude, {}}; };
  return hidden;
}

}  // namespace driftwise::foreign
