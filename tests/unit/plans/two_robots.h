#pragma once
// Models of two robots by hand. "ma": three vertical axes at radius 60 mm, 120 degrees apart, which
// give rx, ry, z; "mn": x, y, z, each its own axis. Predicted: ma moves sideways with z, mn tilts
// with x and y, as figure 7.20 of the study adds them.

#include <array>
#include <cmath>
#include <numbers>

#include "server/calibration/model/model.h"
#include "server/core/description/cell_description.h"
#include "server/plans/joint_builder.h"
#include "server/plans/serving_plan.h"

namespace driftwise::plans {

constexpr double kRadius_mm = 60, kRadOfArcsec = std::numbers::pi / (180.0 * 3600.0);
constexpr ModelId kMicroNano{12}, kFine{11}, kCoarse{10}, kMinAngleMotion{13}, kMicroNanoTilt{14};

inline effects::Term product_of(std::initializer_list<effects::Power> powers) {
  effects::Term out;
  for (const auto& power : powers) out.factors.emplace_back(power);
  return out;
}

struct Coefficient {
  effects::Term term;
  double value;
};

inline calibration::OutputModel output_of(Channel channel, std::vector<Coefficient> terms,
                                          double u_per_term, double rmse) {
  calibration::OutputModel out;
  out.channel = std::move(channel);
  const auto count = static_cast<Eigen::Index>(terms.size());
  out.coefficients.resize(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    out.terms.push_back(terms[static_cast<std::size_t>(k)].term);
    out.coefficients[k] = terms[static_cast<std::size_t>(k)].value;
  }
  out.covariance = Eigen::MatrixXd::Zero(count, count);
  out.covariance(0, 0) = u_per_term * u_per_term;
  out.dof = 100;
  out.accuracy.rmse = rmse;
  return out;
}

inline double axis_angle(int axis) { return 2 * std::numbers::pi * axis / 3 + 0.3; }

// turned_arcsec: its rx is so much out.
inline calibration::Model min_angle(double reach_arcsec, double reach_z_mm, double turned_arcsec,
                                    double rmse_mm, const std::string& id = "ma.") {
  calibration::Model model;
  for (int i = 0; i < 3; ++i) {
    const double by_rx = kRadius_mm * std::sin(axis_angle(i)) * kRadOfArcsec;
    const double by_ry = -kRadius_mm * std::cos(axis_angle(i)) * kRadOfArcsec;
    model.outputs.push_back(output_of({id + "q" + std::to_string(i + 1), "mm"},
                                      {{{}, by_rx * turned_arcsec},
                                       {product_of({{id + "rx", 1}}), by_rx},
                                       {product_of({{id + "ry", 1}}), by_ry},
                                       {product_of({{id + "z", 1}}), 1.0},
                                       {product_of({{id + "rx", 1}, {id + "ry", 1}}), 2e-9}},
                                      1e-5, rmse_mm));
  }
  model.domain = {{{id + "rx", "arcsec"}, -reach_arcsec, reach_arcsec},
                  {{id + "ry", "arcsec"}, -reach_arcsec, reach_arcsec},
                  {{id + "z", "mm"}, -reach_z_mm, reach_z_mm}};
  return model;
}

inline calibration::Model micro_nano() {
  calibration::Model model;
  const std::array<std::string, 3> axes = {"mn.x", "mn.y", "mn.z"};
  for (std::size_t i = 0; i < 3; ++i)
    model.outputs.push_back(output_of({"mn.q" + std::to_string(i + 1), "mm"},
                                      {{{}, 0.1},
                                       {product_of({{axes[i], 1}}), 1.0},
                                       {product_of({{"mn.x", 2}}), 1e-3},
                                       {product_of({{"t05", 1}}), 2e-4}},
                                      2e-5, 5e-5));
  for (const auto& axis : axes) model.domain.push_back({{axis, "mm"}, -2.5, 2.5});
  model.domain.push_back({{"t05", "degC"}, 19, 22});
  return model;
}

// dx = 1 um per mm of z, dy = -2/3 um per mm: the study's example, 3 um and -2 um at z = 3 mm.
inline calibration::Model min_angle_motion() {
  calibration::Model model;
  const double shares[] = {1e-3, -2e-3 / 3};
  const char* names[] = {"ma.x", "ma.y"};
  for (int i = 0; i < 2; ++i)
    model.outputs.push_back(output_of({names[i], "mm"},
                                      {{{}, -20 * 1e-4 * (i + 1)},
                                       {product_of({{"ma.z", 1}}), shares[i]},
                                       {product_of({{"t09", 1}}), 1e-4 * (i + 1)}},
                                      3e-4, 4e-4));
  model.domain = {{{"ma.z", "mm"}, -4, 4}, {{"t09", "degC"}, 19, 22}};
  return model;
}

// rx = 10 arcsec per mm of y, ry = -20 arcsec per mm of x, rz = 5 arcsec per mm of x.
inline calibration::Model micro_nano_tilt() {
  calibration::Model model;
  model.outputs = {
      output_of({"mn.rx", "arcsec"}, {{{}, 0}, {product_of({{"mn.y", 1}}), 10}}, 0.3, 0.4),
      output_of({"mn.ry", "arcsec"}, {{{}, 0}, {product_of({{"mn.x", 1}}), -20}}, 0.3, 0.4),
      output_of({"mn.rz", "arcsec"}, {{{}, 0}, {product_of({{"mn.x", 1}}), 5}}, 0.3, 0.4)};
  model.domain = {{{"mn.x", "mm"}, -2.5, 2.5}, {{"mn.y", "mm"}, -2.5, 2.5}};
  return model;
}

// One more term: the output changes by slope with this coordinate.
inline void add_slope(calibration::OutputModel& output, const std::string& by, double slope) {
  const auto count = output.coefficients.size();
  output.terms.push_back(product_of({{by, 1}}));
  output.coefficients.conservativeResize(count + 1);
  output.coefficients[count] = slope;
  output.covariance.conservativeResizeLike(Eigen::MatrixXd::Zero(count + 1, count + 1));
}

// The MinAngle's sideways motion follows its rx as well, by mm per arcsec in x and y: with the
// tilts of the Micro-Nano a circle, of which a pass leaves 10 arcsec/mm times as much.
inline void follow_the_tilt(calibration::Model& motion, double mm_per_arcsec) {
  for (auto& output : motion.outputs) add_slope(output, "ma.rx", mm_per_arcsec);
  motion.domain.push_back({{"ma.rx", "arcsec"}, -300, 300});
}

inline CellDescription two_robot_cell() {
  CellDescription cell;
  DeviceDescription scanner;
  scanner.id = "scanner";
  for (const char* name : {"t05", "t09"}) {
    auto& probe = scanner.become<TemperatureSettings>().probes.emplace_back();
    probe.channel = {name, "degC"};
    probe.u_k = 0.002;
  }
  DeviceDescription gantry;
  gantry.id = "gantry";
  for (const char* name : {"ma.q1", "ma.q2", "ma.q3"})
    gantry.become<MotionSettings>().axes.push_back(
        {.channel = {name, "mm"}, .device_axis = "X", .min_mm = -5, .max_mm = 5, .u_scale_nm = 70});
  DeviceDescription hexapod;
  hexapod.id = "hexapod";
  for (const char* name : {"mn.q1", "mn.q2", "mn.q3"})
    hexapod.become<MotionSettings>().axes.push_back(
        {.channel = {name, "mm"}, .device_axis = "X", .min_mm = -4, .max_mm = 4, .u_scale_nm = 3});
  cell.devices = {scanner, gantry, hexapod};
  cell.serving.max_age_s = 60;
  cell.serving.rebuild_period_s = 5;
  return cell;
}

inline Blend study_band() {
  return {kCoarse,
          {{compensation::Variable::rx, 300, 350, {}}, {compensation::Variable::ry, 300, 350, {}}},
          false};
}

inline ServingPlan joint_plan() {
  ServingPlan plan;
  plan.name = "joint";
  plan.robots = {{"mn", kMicroNano, {}, ""}, {"ma", kFine, study_band(), ""}};
  plan.steps = {
      {kMinAngleMotion, "ma", "mn", {compensation::Variable::x, compensation::Variable::y}},
      {kMicroNanoTilt, "mn", "ma", {compensation::Variable::rx, compensation::Variable::ry}}};
  plan.z_taken_by = "mn";
  return plan;
}

inline ModelsById joint_models(double turned_arcsec = 3) {
  return {{kMicroNano, micro_nano()},
          {kFine, min_angle(300, 4, 0, 1e-4)},
          {kCoarse, min_angle(18'000, 4, turned_arcsec, 1e-2)},
          {kMinAngleMotion, min_angle_motion()},
          {kMicroNanoTilt, micro_nano_tilt()}};
}

}  // namespace driftwise::plans
