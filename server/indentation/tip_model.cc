#include "server/indentation/tip_model.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "server/core/reasons.h"
#include "server/core/text/quantity_text.h"
#include "server/core/text/shown_text.h"

namespace driftwise::indentation {
namespace {

constexpr double kPpm = 1e6;
// The study's curves: a straight line along x, a parabola along y.
constexpr int kCurveDegreeX = 1, kCurveDegreeY = 2;

double correlation_of(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  const Eigen::VectorXd u = a.array() - a.mean(), v = b.array() - b.mean();
  const double size = u.norm() * v.norm();
  return size > 0 ? u.dot(v) / size : 0;
}

// Of the first indent's marking, which every row of a line has in it: p m / root of 3, in the
// finest of the pictures, um^2.
double common_um2_of(const std::vector<const IndentRow*>& rows) {
  double common_um2 = std::numeric_limits<double>::infinity();
  for (const IndentRow* row : rows) {
    const double marking_um = row->indent.pixel_nm * 1e-3 * row->indent.marking_px;
    common_um2 = std::min(common_um2, marking_um * marking_um / 3);
  }
  return common_um2;
}

LineFit fit_line(Line line, const std::vector<const IndentRow*>& rows) {
  const auto n = static_cast<Eigen::Index>(rows.size());
  Eigen::MatrixXd design(n, 2);
  Eigen::VectorXd error_um(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto& row = *rows[static_cast<std::size_t>(i)];
    design.row(i) << row.indent.wanted_um, row.lever_um;
    error_um[i] = row.error_um;
  }
  LineFit fit{.line = line, .indents = static_cast<int>(n)};
  fit.correlation = correlation_of(design.col(0), design.col(1));
  fit.rms_um = std::sqrt(error_um.squaredNorm() / static_cast<double>(n));
  Eigen::Index at = 0;
  if (const double largest = error_um.cwiseAbs().maxCoeff(&at); largest > 0)
    fit.lever_share = design(at, 1) / error_um[at];
  const auto qr = design.colPivHouseholderQr();
  if (qr.rank() < 2) return fit;  // no rotation at all, or exactly along the distance
  const Eigen::Vector2d found = qr.solve(error_um);
  const double variance = (error_um - design * found).squaredNorm() /
                          static_cast<double>(std::max<Eigen::Index>(1, n - 2));
  // A common error is no scatter about the line: the scale takes it up.
  const Eigen::Vector2d by_common = qr.solve(Eigen::VectorXd::Ones(n));
  const Eigen::Matrix2d covariance = variance * (design.transpose() * design).inverse() +
                                     common_um2_of(rows) * by_common * by_common.transpose();
  fit.scale_ppm = found[0] * kPpm;
  fit.u_scale_ppm = std::sqrt(covariance(0, 0)) * kPpm;
  fit.factor = found[1];
  fit.u_factor = std::sqrt(covariance(1, 1));
  fit.separable = std::abs(fit.correlation) < kSeparable && fit.u_factor < kUsableFactor;
  return fit;
}

ErrorCurve fit_curve(Line line, const std::vector<const IndentRow*>& rows) {
  const int degree = line == Line::x ? kCurveDegreeX : kCurveDegreeY;
  const auto n = static_cast<Eigen::Index>(rows.size()) + 1;
  Eigen::MatrixXd design = Eigen::MatrixXd::Zero(n, degree + 1);
  Eigen::VectorXd error_um = Eigen::VectorXd::Zero(n);
  design(0, 0) = 1;  // the first indent
  for (Eigen::Index i = 1; i < n; ++i) {
    const auto& row = *rows[static_cast<std::size_t>(i - 1)];
    for (int k = 0; k <= degree; ++k) design(i, k) = std::pow(row.indent.wanted_um, k);
    error_um[i] = row.error_um;
  }
  const Eigen::VectorXd found = design.colPivHouseholderQr().solve(error_um);
  return {.line = line,
          .coefficients = {found.begin(), found.end()},
          .rms_um = std::sqrt((error_um - design * found).squaredNorm() / static_cast<double>(n))};
}

// Wilson and Hilferty's approximation, Proc. Natl. Acad. Sci. 17 (1931) 684: within 0.6 % from 2
// degrees of freedom on.
double chi2_limit(int degrees) {
  constexpr double kNormal95 = 1.6449;
  const double part = 2 / (9.0 * degrees);
  return degrees * std::pow(1 - part + kNormal95 * std::sqrt(part), 3);
}

// Minimum of a convex function between low and high.
template <class Function>
double least_of(const Function& function, double low, double high) {
  for (int i = 0; i < 200; ++i) {
    const double third = (high - low) / 3;
    if (function(low + third) < function(high - third))
      high -= third;
    else
      low += third;
  }
  return function((low + high) / 2);
}

LineTest test_line(Line line, const std::vector<const IndentRow*>& rows, double wanted_um) {
  LineTest test{.line = line, .indents = static_cast<int>(rows.size())};
  test.limit = chi2_limit(test.indents);
  const double common_um2 = common_um2_of(rows);
  double largest_um = 0;
  for (const IndentRow* row : rows) largest_um = std::max(largest_um, std::abs(row->error_um));
  const auto chi2 = [&](double first_um) {
    double sum = common_um2 > 0 ? first_um * first_um / common_um2 : 0;
    for (const IndentRow* row : rows) {
      const double own_um2 = row->u_um * row->u_um - common_um2;
      const double beyond_um = std::max(0.0, std::abs(row->error_um - first_um) - wanted_um);
      if (beyond_um > 0 && own_um2 > 0) sum += beyond_um * beyond_um / own_um2;
    }
    return sum;
  };
  test.chi2 = common_um2 > 0 ? least_of(chi2, -largest_um, largest_um) : chi2(0);
  return test;
}

void judge(TipReport& report, std::span<const IndentRow> rows, double wanted_um) {
  const auto by = [&](double sign) {
    return *std::ranges::max_element(rows, {}, [sign](const IndentRow& row) {
      return std::abs(row.error_um) + sign * row.half_width_um;
    });
  };
  const IndentRow largest = by(1), surest = by(-1);
  const std::string wanted = quantity_text(wanted_um * 1e3, "nm");
  const auto shown_row = [](const IndentRow& row) {
    return "indent " + row.indent.id + ": error " + digits_text(row.error_um, 4) + " um, U " +
           digits_text(row.half_width_um, 4) + " um";
  };
  const auto missed = std::ranges::find_if(
      report.tests, [](const LineTest& test) { return test.chi2 > test.limit; });
  const std::string consequence =
      "; a calibration at the cube does not hold at the tip, and a curve through these indents "
      "improves these indents only";
  if (std::abs(surest.error_um) - surest.half_width_um > wanted_um) {
    report.conformity = Conformity::beyond;
    report.verdict = "return to step 0: the largest error at the tool is beyond the wanted " +
                     wanted + " by more than the marking's uncertainty (" + shown_row(surest) +
                     ")" + consequence;
  } else if (missed != report.tests.end()) {
    report.conformity = Conformity::beyond;
    report.verdict = "return to step 0: no indent alone, and those of line " +
                     std::string(to_string(missed->line)) +
                     " together show that the error at the tool is beyond the wanted " + wanted +
                     ": chi2 is at least " + digits_text(missed->chi2, 3) + " with " +
                     std::to_string(missed->indents) + " indents, within it would be at most " +
                     digits_text(missed->limit, 3) + " (95 %)" + consequence;
  } else if (std::abs(largest.error_um) + largest.half_width_um <= wanted_um) {
    report.conformity = Conformity::within;
    report.verdict =
        "accuracy at the tool is within " + wanted + " at every indent, the marking's U included";
  } else {
    report.conformity = Conformity::undecided;
    report.verdict = "cannot be told with these pictures: wanted is " + wanted + ", and with " +
                     shown_row(largest) + " the true error may be within it or beyond";
  }
}

}  // namespace

std::string_view to_string(Conformity conformity) {
  switch (conformity) {
    case Conformity::within:
      return "within";
    case Conformity::undecided:
      return "undecided";
    case Conformity::beyond:
      return "beyond";
  }
  return "";
}

std::string_view to_string(Line line) { return line == Line::x ? "x" : "y"; }

Result<TipReport> tip_report(std::span<const IndentRow> rows, double wanted_accuracy_um) {
  if (!(wanted_accuracy_um > 0) || !std::isfinite(wanted_accuracy_um))
    return fail(ErrorCode::invalid_argument, reasons::kBadValue,
                "the wanted accuracy is " + number_text(wanted_accuracy_um) +
                    " um, expected finite and above 0");
  TipReport report;
  for (const Line line : {Line::x, Line::y}) {
    std::vector<const IndentRow*> along;
    for (const IndentRow& row : rows)
      if (row.indent.line == line) along.push_back(&row);
    if (!along.empty()) report.tests.push_back(test_line(line, along, wanted_accuracy_um));
    if (along.size() < 3) continue;
    report.lines.push_back(fit_line(line, along));
    report.curves.push_back(fit_curve(line, along));
  }
  if (report.lines.empty())
    return fail(ErrorCode::failed_precondition, reasons::kTooFewRows,
                "no line has 3 indents, found " + std::to_string(rows.size()) +
                    " in all: lever and scale of a line cannot be fitted");
  judge(report, rows, wanted_accuracy_um);
  if (report.conformity == Conformity::within) return report;
  if (report.conformity == Conformity::undecided) {
    report.change = {
        "pictures with smaller pixels, until U = 2 m p + k p / 2 is below the wanted accuracy less "
        "the error",
        "indents marked with fewer pixels of doubt, fewer pictures joined",
        "more indents along the line: they are judged together"};
    return report;
  }
  if (std::ranges::any_of(report.lines, [](const LineFit& fit) { return !fit.separable; })) {
    report.indistinguishable = {"tool lever", "microscope scale"};
    report.separating = {
        "indents at one place of the work-piece, approached with the robot above elsewhere: the "
        "rotations change, the distance does not",
        "the same lines with a tool of another length: only the lever's part changes",
        "the work-piece turned by 90 degrees under the microscope: only the scale's part changes",
        "a calibrated scale in the microscope's picture beside the indents"};
  }
  report.change = {
      "measure at the tool: mirrors on the tool's support, beams as near the tip as possible",
      "limit the parasitic rotations, or use a robot with six degrees of freedom",
      "a shorter lever: tool length and the way from the cube to its fixation",
      "the robots nearer to each other, lower supports"};
  return report;
}

}  // namespace driftwise::indentation
