#pragma once
// What a table of indents can tell about the tool: lever and microscope scale, line by line,
// whether they can be told apart, and what to do then. Pure.
//
// Model of a line: error = scale x wanted + factor x lever part. factor: real lever over stated
// one, 1 for a rigid tool of the stated length: dx = a lever sin ry with a = -factor on the x line,
// dy = c lever sin rx with c = +factor on the y line. Least squares without a constant: the first
// indent counts as 0 by definition.
// Source: E. Lubrano, EPFL thesis 5098 (2011), sections 8.2.4 and 8.4; sizes of a, c by a rigid
// body.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "server/indentation/indent_table.h"

namespace driftwise::indentation {

struct LineFit {
  Line line = Line::x;
  int indents = 0;
  double factor = 0, u_factor = 0;        // by the scatter about the line
  double scale_ppm = 0, u_scale_ppm = 0;  // of the microscope, or of the robot's own scale
  double correlation = 0;                 // of the distances and the lever parts, centred
  double rms_um = 0;                      // of the error, nothing modelled
  double lever_share = 0;  // of the largest error: the rigid lever's part, by the stated length
  bool separable = false;  // correlation below kSeparable and u_factor below kUsableFactor
};

inline constexpr double kSeparable = 0.99, kUsableFactor = 0.25;

// Polynomial through the errors and the first indent (0, 0): the study's correction curve.
struct ErrorCurve {
  Line line = Line::x;
  std::vector<double> coefficients{};  // um, from the constant on; of um
  double rms_um = 0;
};

struct TipReport {
  std::vector<LineFit> lines{};
  std::vector<ErrorCurve> curves{};
  std::vector<std::string> indistinguishable{};  // "tool lever", "microscope scale"; empty: none
  std::vector<std::string> separating{};         // measurements that tell them apart
  std::string verdict{};
  std::vector<std::string> change{};  // what to change before the next calibration
};

// wanted_accuracy_um: the verdict is against it. Errors, failed_precondition TOO_FEW_ROWS: no
// line has three indents.
Result<TipReport> tip_report(std::span<const IndentRow> rows, double wanted_accuracy_um);

std::string_view to_string(Line line);

}  // namespace driftwise::indentation
