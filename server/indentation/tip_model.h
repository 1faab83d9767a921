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
//
// Verdict: ISO 14253-1, with the marking's U. Where no indent alone is beyond, those of a line are
// judged together: chi2 is the least sum of (true error less error seen)^2 / u^2 over true errors
// that all lie within the wanted accuracy. The marking of the first indent is one quantity, common
// to the line. Beyond: chi2 above its 95 % with as many degrees of freedom as indents, which is on
// the safe side.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "server/indentation/indent_table.h"

namespace driftwise::indentation {

struct LineFit {
  Line line = Line::x;
  int indents = 0;
  double factor = 0, u_factor = 0;        // by the scatter about the line and the common zero
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

enum class Conformity {
  within,     // |error| + U of every indent is within the wanted accuracy
  undecided,  // neither: the pictures are too coarse to tell
  beyond,     // |error| - U of an indent is beyond it, or a line is by its chi2
};

// Errors of a line against the wanted accuracy.
struct LineTest {
  Line line = Line::x;
  int indents = 0;
  double chi2 = 0, limit = 0;  // 95 %
};

struct TipReport {
  std::vector<LineFit> lines{};
  std::vector<ErrorCurve> curves{};
  std::vector<std::string> indistinguishable{};  // "tool lever", "microscope scale"; empty: none
  std::vector<std::string> separating{};         // measurements that tell them apart
  Conformity conformity = Conformity::undecided;
  std::vector<LineTest> tests{};  // lines with an indent
  std::string verdict{};
  // What to change before the next calibration; undecided: for the next pictures; within: nothing.
  std::vector<std::string> change{};
};

// wanted_accuracy_um: the verdict is against it. Errors, failed_precondition TOO_FEW_ROWS: no
// line has three indents.
Result<TipReport> tip_report(std::span<const IndentRow> rows, double wanted_accuracy_um);

std::string_view to_string(Line line);
std::string_view to_string(Conformity conformity);

}  // namespace driftwise::indentation
