#pragma once
// A small model by hand, and the cell it serves in: q1 = 1 + 2 x + 0.5 x^2 + 1e-3 t07 + 2e-4 x t07
// (mm, degC).

#include "server/calibration/model/model.h"
#include "server/core/description/cell_description.h"

namespace driftwise::compensation {

inline effects::Term term(std::initializer_list<effects::Factor> factors) { return {factors}; }
inline effects::Power power(const char* symbol, int exponent = 1) { return {symbol, exponent}; }

inline calibration::Model axis_model() {
  calibration::Model model;
  model.formula = "q1 ~ x + x^2 + t07 + x:t07";
  calibration::OutputModel q1;
  q1.channel = {"q1", "mm"};
  q1.terms = {term({}), term({power("x")}), term({power("x", 2)}), term({power("t07")}),
              term({power("x"), power("t07")})};
  q1.coefficients.resize(5);
  q1.coefficients << 1.0, 2.0, 0.5, 1e-3, 2e-4;
  Eigen::MatrixXd half = Eigen::MatrixXd::Identity(5, 5) * 1e-6;
  half(1, 0) = 4e-7;
  half(3, 1) = -3e-7;
  half(4, 2) = 2e-8;
  q1.covariance = half * half.transpose();  // positive definite by construction
  q1.dof = 100;
  q1.accuracy.rmse = 8e-6;
  model.outputs = {q1};
  model.domain = {{{"x", "mm"}, -4, 4}, {{"t07", "degC"}, 20, 22}};
  return model;
}

inline CellDescription axis_cell() {
  CellDescription cell;
  DeviceDescription axis;
  axis.id = "axis";
  axis.become<MotionSettings>().axes = {{.channel = {"q1", "mm"},
                                         .device_axis = "X",
                                         .min_mm = -250,
                                         .max_mm = 250,
                                         .u_scale_nm = 3}};
  DeviceDescription scanner;
  scanner.id = "scanner";
  scanner.become<TemperatureSettings>().probes.emplace_back();
  scanner.become<TemperatureSettings>().probes[0].channel = {"t07", "degC"};
  scanner.become<TemperatureSettings>().probes[0].u_k = 0.002;
  cell.devices = {axis, scanner};
  cell.serving.max_age_s = 60;
  cell.serving.rebuild_period_s = 5;
  return cell;
}

}  // namespace driftwise::compensation
