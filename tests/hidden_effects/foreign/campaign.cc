#include "tests/hidden_effects/foreign/campaign.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "tests/hidden_effects/foreign/monomials.h"
#include "tests/hidden_effects/foreign/strength.h"

namespace driftwise::foreign {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

void draw_thermometers(Campaign& campaign, const Needs& needs, bool vary, Random& random) {
  int count = vary ? random.pick(std::vector<int>{0, 1, 2, 3, 4, 5, 6, 8, 10, 13, 20}) : 6;
  count = std::max(count, needs.thermometers);
  const double noise_k = vary ? random.log_uniform(2e-4, 4e-3) : 1e-3;
  const double quantum_k = vary ? random.pick(std::vector<double>{0.0, 1e-4, 1e-3, 1e-2}) : 1e-3;
  const double filter_s = vary && random.chance(0.3) ? random.uniform(20.0, 90.0) : 0.0;
  static const std::vector<std::string> parts{"robot", "robot", "robot", "instrument", "base"};
  for (int k = 0; k < count; ++k) {
    Thermometer one;
    one.part = random.pick(parts);
    one.tau_s = random.log_uniform(250.0, 7000.0);
    one.air_share = random.uniform(0.3, 1.0);
    one.motor_k = needs.unsensed_heat ? 0.0 : random.uniform(0.0, 8.0);
    one.activity_k = needs.unsensed_heat ? 0.0 : random.uniform(0.0, 2.0);
    one.offset_k = random.normal() * 0.3;
    one.noise_k = noise_k;
    one.quantum_k = quantum_k;
    one.filter_s = filter_s;
    campaign.thermometers.push_back(one);
  }
}

void draw_force(std::vector<Visit>& visits, Random& random) {
  // Loads in blocks of uneven length, order at random.
  double level = 0.0;
  int left = 0;
  for (Visit& visit : visits) {
    if (left-- <= 0) {
      level = random.below(6) / 5.0;
      left = 8 + random.below(25);
    }
    visit.force = level;
  }
}

void split_runs(std::vector<Visit>& visits, int runs, Random& random) {
  const int count = static_cast<int>(visits.size());
  int run = 1;
  for (int k = 0; k < count; ++k) {
    if (run < runs && k > 0 && k >= run * count / runs && visits[k].line != visits[k - 1].line) {
      ++run;
      visits[k].pause_s += random.uniform(300.0, 2500.0);
    }
    visits[k].run = visits[k].datum = run;
  }
}

// Clock of the campaign: moves, dwells, pauses. Returns the duration in s.
double run_clock(Campaign& campaign, std::vector<Visit>& visits, double duration_wanted_s,
                 std::vector<ActivityChange>& activity, Random& random) {
  const double stroke_time_s = random.uniform(3.0, 15.0);
  const double measuring_s = random.uniform(1.0, 3.0);
  double overhead_s = random.uniform(3.0, 20.0);
  if (duration_wanted_s > 0.0) {
    overhead_s = duration_wanted_s / static_cast<double>(visits.size());
  }
  VectorXd at = visits.front().s;
  double now = 0.0;
  std::vector<double> times;
  for (const Visit& visit : visits) {
    activity.push_back({now, visit.activity});
    const double move_s = 0.5 + 0.5 * stroke_time_s * (visit.s - at).cwiseAbs().maxCoeff();
    campaign.moves.push_back({now, now + move_s, at, visit.s});
    now += move_s + visit.dwell_s;
    if (visit.measured) {
      now += 0.5 * measuring_s;
      times.push_back(now);
      campaign.visits.push_back(visit);
      now += 0.5 * measuring_s + overhead_s * random.uniform(0.9, 1.1);
    }
    now += visit.pause_s;
    at = visit.s;
  }
  campaign.time_s =
      Eigen::Map<const VectorXd>(times.data(), static_cast<Eigen::Index>(times.size()));
  return now;
}

void draw_sets(Campaign& campaign, bool vary, Random& random) {
  const int rows = campaign.rows();
  campaign.has_sets = !vary || random.chance(0.8);
  const int way = vary ? random.below(3) : 0;
  const int block = 8 + random.below(15);
  for (int i = 0; i < rows; ++i) {
    bool held_out = false;
    if (campaign.has_sets) {
      const int line = campaign.visits[i].line;
      held_out = way == 0 ? line % 3 == 2 : way == 1 ? i > rows * 7 / 10 : (i / block) % 3 == 1;
    }
    (held_out ? campaign.validation : campaign.calibration).push_back(i);
  }
  // A plan of one long line has no other line to hold out.
  if (static_cast<int>(campaign.calibration.size()) < rows / 3) {
    campaign.calibration.clear();
    campaign.validation.clear();
    for (int i = 0; i < rows; ++i) {
      ((i / block) % 3 == 1 ? campaign.validation : campaign.calibration).push_back(i);
    }
  }
}

void draw_tilts(Campaign& campaign, Random& random) {
  const MatrixXd u = campaign.clean_u();
  campaign.tilt.setZero(campaign.rows(), 3);
  const double size = random.log_uniform(3.0, 60.0);
  for (int k = 0; k < 3; ++k) {
    double state = random.normal();
    const double tau_s = random.uniform(600.0, 3000.0);
    std::vector<double> slope;
    std::vector<double> bow;
    for (int j = 0; j < campaign.robot.axes; ++j) {
      slope.push_back(random.normal());
      bow.push_back(0.4 * random.normal());
    }
    for (int i = 0; i < campaign.rows(); ++i) {
      if (i > 0) {
        const double keep = std::exp(-(campaign.time_s[i] - campaign.time_s[i - 1]) / tau_s);
        state = keep * state + std::sqrt(1.0 - keep * keep) * random.normal();
      }
      double value = 0.7 * state;
      for (int j = 0; j < campaign.robot.axes; ++j) {
        value += slope[j] * u(i, j) + bow[j] * u(i, j) * u(i, j);
      }
      campaign.tilt(i, k) = size * value;
    }
  }
}

void read_sensors(Campaign& campaign, Random& random) {
  const int rows = campaign.rows();
  const int count = campaign.thermometer_count();
  campaign.body.resize(rows, count);
  campaign.read.resize(rows, count);
  campaign.air_degc.resize(rows);
  campaign.pressure_hpa.resize(rows);
  campaign.humidity_pct.resize(rows);
  campaign.force_n.setZero(rows);
  campaign.activity.resize(rows);
  const double force_max_n = random.log_uniform(0.5, 60.0);
  for (int i = 0; i < rows; ++i) {
    const double t = campaign.time_s[i];
    for (int k = 0; k < count; ++k) {
      const Thermometer& one = campaign.thermometers[k];
      campaign.body(i, k) = campaign.room.at(campaign.room.body.col(k), t);
      double read =
          campaign.room.at(campaign.room.sensed.col(k), t) + one.noise_k * random.normal();
      if (one.quantum_k > 0.0) {
        read = std::round(read / one.quantum_k) * one.quantum_k;
      }
      campaign.read(i, k) = read;
    }
    campaign.air_degc[i] = campaign.room.at(campaign.room.air_degc, t);
    campaign.pressure_hpa[i] = campaign.room.at(campaign.room.pressure_hpa, t);
    campaign.humidity_pct[i] = campaign.room.at(campaign.room.humidity_pct, t);
    campaign.force_n[i] = campaign.has_force ? force_max_n * campaign.visits[i].force : 0.0;
    campaign.activity[i] = campaign.visits[i].activity;
  }
}

// Drift that the thermometers explain: 10 to 80 sigma over the campaign, spread over some of them.
void draw_linear_laws(Campaign& campaign, Random& random) {
  const Robot& robot = campaign.robot;
  campaign.thermal.setZero(robot.axes, campaign.thermometer_count());
  campaign.compliance.setZero(robot.axes);
  const double size = random.log_uniform(10.0, 80.0);
  for (int i = 0; i < robot.axes; ++i) {
    const double unit = robot.sigma[i] / robot.half[i];
    for (const int k : campaign.offered) {
      if (random.chance(0.7)) {
        const auto column = campaign.body.col(k);
        const double span = std::max(column.maxCoeff() - column.minCoeff(), 0.02);
        campaign.thermal(i, k) = size * unit * random.normal() / span;
      }
    }
    if (campaign.has_force && campaign.force_offered) {
      campaign.compliance[i] =
          size * unit * random.normal() / std::max(campaign.force_n.maxCoeff(), 1e-9);
    }
  }
  // What quantisation, filters and noise of the thermometers leave must not be an effect.
  const Whitened whitened(campaign, campaign.read);
  const MatrixXd none = campaign.no_motor_error();
  const MatrixXd leak = campaign.effect(campaign.pose(none, none, campaign.body),
                                        campaign.pose(none, none, campaign.read));
  const double chi2 = whitened.chi2(leak);
  constexpr double kLargestLeak = 5.0;
  if (chi2 > kLargestLeak) {
    campaign.thermal *= std::sqrt(kLargestLeak / chi2);
  }
}

std::string drawn_robot(const CampaignChoice& choice, Random& random) {
  const bool vary = choice.vary.robot;
  const bool small = random.chance(0.5);
  const std::string drawn = random.pick(choice.reserved ? reserved_robots() : open_robots());
  if (!choice.robot.empty()) {
    return choice.robot;
  }
  return vary ? drawn : small ? "linear" : "gantry";
}

}  // namespace

MatrixXd Campaign::acting_motors(const MatrixXd& dq, const MatrixXd& temperature) const {
  MatrixXd out(rows(), robot.axes);
  for (int i = 0; i < rows(); ++i) {
    VectorXd effective =
        s.row(i).transpose() - dq.row(i).transpose().cwiseQuotient(robot.motor_half);
    if (thermometer_count() > 0) {
      effective -= thermal * (temperature.row(i) - temperature.row(0)).transpose();
    }
    effective -= compliance * force_n[i];
    out.row(i) = effective.transpose();
  }
  return out;
}

MatrixXd Campaign::pose(const MatrixXd& dq, const MatrixXd& dp, const MatrixXd& temperature) const {
  const MatrixXd acting = acting_motors(dq, temperature);
  MatrixXd out(rows(), robot.axes);
  for (int i = 0; i < rows(); ++i) {
    const VectorXd u = robot.pose_of(acting.row(i).transpose());
    for (int j = 0; j < robot.axes; ++j) {
      out(i, j) = robot.pose_value(j, u[j]) + dp(i, j);
    }
  }
  return out;
}

double Campaign::largest_gap(const MatrixXd& pose, const MatrixXd& acting) const {
  if (!pose.allFinite()) {
    return std::numeric_limits<double>::infinity();
  }
  double largest = 0.0;
  for (int i = 0; i < rows(); ++i) {
    const VectorXd motors = robot.motor_of(robot.normalised(pose.row(i).transpose()));
    largest = std::max(largest, (motors - acting.row(i).transpose()).cwiseAbs().maxCoeff());
  }
  return largest;
}

MatrixXd Campaign::effect(const MatrixXd& with, const MatrixXd& without) const {
  const auto back = robot.linear.partialPivLu();
  MatrixXd out(rows(), robot.axes);
  for (int i = 0; i < rows(); ++i) {
    const VectorXd gap = robot.motor_of(robot.normalised(with.row(i).transpose())) -
                         robot.motor_of(robot.normalised(without.row(i).transpose()));
    out.row(i) = back.solve(gap).cwiseProduct(robot.half).transpose();
  }
  return out;
}

MatrixXd Campaign::clean_u() const {
  MatrixXd out(rows(), robot.axes);
  for (int i = 0; i < rows(); ++i) {
    out.row(i) = robot.pose_of(s.row(i).transpose()).transpose();
  }
  return out;
}

MatrixXd Campaign::design(const MatrixXd& temperature) const {
  const MatrixXd u = clean_u();
  const std::vector<std::vector<int>> powers = monomials(robot.axes, degree);
  const auto count = static_cast<Eigen::Index>(powers.size());
  const auto heat = static_cast<Eigen::Index>(offered.size());
  MatrixXd columns(rows(), 1 + count + heat + (force_offered ? 1 : 0));
  for (int i = 0; i < rows(); ++i) {
    columns(i, 0) = 1.0;
    for (Eigen::Index k = 0; k < count; ++k) {
      columns(i, 1 + k) = monomial_value(powers[static_cast<std::size_t>(k)], u.row(i).transpose());
    }
    for (Eigen::Index k = 0; k < heat; ++k) {
      const int sensor = offered[static_cast<std::size_t>(k)];
      columns(i, 1 + count + k) = temperature(i, sensor) - temperature(0, sensor);
    }
    if (force_offered) {
      columns(i, 1 + count + heat) = force_n[i];
    }
  }
  return columns;
}

Campaign make_campaign(const CampaignChoice& choice, const Needs& needs, Random& random) {
  Campaign campaign;
  std::string plan_kind = choice.plan;
  const std::string drawn_plan = random.pick(choice.reserved ? reserved_plans() : open_plans());
  if (plan_kind.empty()) {
    plan_kind = choice.vary.plan ? drawn_plan : "lattice";
  }
  const std::string robot_kind = drawn_robot(choice, random);
  campaign.plan = plan_kind;
  campaign.degree =
      std::min({plan_degree(plan_kind), needs.degree, robot_kind == "linear" ? 2 : 3});
  const double askew = plan_kind == "lattice_askew" ? random.log_uniform(1e-3, 1e-2) : 0.0;
  campaign.robot = make_robot(robot_kind, campaign.degree, askew,
                              !choice.vary.robot && choice.robot.empty(), random);
  if (!regular_in_stroke(campaign.robot)) {
    throw std::runtime_error("the robot is nearly singular within its stroke");
  }
  campaign.degree = std::min(campaign.degree, campaign.robot.degree);
  const int axes = campaign.robot.axes;

  const int wanted = axes == 1 ? 150 + random.below(250) : 220 + random.below(230);
  Plan plan =
      make_plan(plan_kind, axes, wanted, campaign.robot.zero_at_corner ? -1.0 : 0.0, random);
  const bool vary = choice.vary.sensors;
  campaign.has_force = needs.force || needs.force_left_out || (vary && random.chance(0.25));
  campaign.force_offered = campaign.has_force && !needs.force_left_out;
  campaign.has_activity = needs.activity || (vary && random.chance(0.15));
  campaign.has_tilts = (needs.tilts || (vary && random.chance(0.3))) && axes <= 3 &&
                       campaign.robot.pose.back()[0] != 'r';
  campaign.has_air = needs.air || !vary || random.chance(0.5);
  campaign.has_times = needs.times || !vary || random.chance(0.85);
  campaign.has_dwell = !vary || random.chance(0.6);
  campaign.has_lines = !vary || random.chance(0.6);
  campaign.has_runs = vary && random.chance(0.4);
  if (campaign.has_force) {
    draw_force(plan.visits, random);
  }
  if (needs.activity && plan_kind != "warm_up" && plan_kind != "iso230_3") {
    double level = 0.0;
    for (std::size_t k = 0; k < plan.visits.size(); ++k) {
      if (k % 40 == 0) {
        level = random.below(4) / 3.0;
      }
      plan.visits[k].activity = level;
    }
  }
  split_runs(plan.visits, campaign.has_runs ? 1 + random.below(3) : 1, random);

  const std::string drawn_noise = random.pick(noise_kinds());
  const std::string noise_kind = !choice.noise.empty() ? choice.noise
                                 : choice.vary.noise   ? drawn_noise
                                                       : "white";
  std::vector<ActivityChange> activity;
  const double long_s = noise_kind == "day_night" ? random.uniform(24.0, 48.0) * 3600.0 : 0.0;
  const double duration_s = run_clock(campaign, plan.visits, long_s, activity, random);

  draw_thermometers(campaign, needs, vary, random);
  const int spare = std::min(campaign.thermometer_count(), needs.spare);
  for (int k = 0; k < campaign.thermometer_count() - spare; ++k) {
    campaign.offered.push_back(k);
  }
  campaign.room =
      make_room(duration_s, axes, campaign.moves, activity, campaign.thermometers, random);

  // The controller holds to a few sigma; the scales read where it really stands.
  const double hold = vary && random.chance(0.3) ? 0.0 : random.uniform(1.0, 5.0);
  campaign.s.resize(campaign.rows(), axes);
  for (int i = 0; i < campaign.rows(); ++i) {
    for (int j = 0; j < axes; ++j) {
      campaign.s(i, j) = campaign.visits[i].s[j] +
                         hold * campaign.robot.sigma[j] / campaign.robot.half[j] * random.normal();
    }
  }
  read_sensors(campaign, random);
  draw_sets(campaign, vary, random);
  campaign.noise = make_noise(noise_kind, campaign.time_s, campaign.clean_u(), random);
  draw_linear_laws(campaign, random);
  if (campaign.has_tilts) {
    draw_tilts(campaign, random);
  }
  return campaign;
}

}  // namespace driftwise::foreign
