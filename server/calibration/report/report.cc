#include "server/calibration/report/report.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "server/calibration/linear/rank.h"
#include "server/calibration/linear/tail.h"
#include "server/effects/term_order.h"

namespace driftwise::calibration {
namespace {

using Eigen::Index;

// |column|^2 about its mean: row 0 of the triangle is the direction of the constant.
double spread(const Design& design, const Triangle& triangle, int column) {
  const auto values = triangle.columns.col(column);
  return design.constant ? values.tail(values.size() - 1).squaredNorm() : values.squaredNorm();
}

double condition_index(const Triangle& triangle, const std::vector<int>& columns) {
  Eigen::MatrixXd scaled(triangle.columns.rows(), static_cast<Index>(columns.size()));
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const auto column = triangle.columns.col(columns[i]);
    scaled.col(static_cast<Index>(i)) = column / std::max(column.norm(), 1e-300);
  }
  if (scaled.size() == 0) return 1;
  const Eigen::VectorXd values = Eigen::JacobiSVD<Eigen::MatrixXd>(scaled).singularValues();
  const double smallest = values[values.size() - 1];
  return smallest > 0 ? values[0] / smallest : HUGE_VAL;
}

std::string action_name(char action) {
  return action == 'e' ? "enter" : action == 'r' ? "remove" : "start";
}

TermReport inside_report(const Design& design, const Triangle& triangle, const Solution& solution,
                         Index i) {
  const int column = solution.columns[static_cast<std::size_t>(i)];
  TermReport report;
  report.term = design.terms[static_cast<std::size_t>(column)];
  report.in = true;
  report.coefficient = solution.coefficients[i];
  report.standard_error = solution.standard_error(i);
  if (report.standard_error > 0)
    report.t = report.coefficient / report.standard_error;
  else if (report.coefficient != 0 && solution.dof > 0)
    report.t = std::copysign(HUGE_VAL, report.coefficient);
  report.p = solution.dof > 0 ? t_two_sided_p(report.t, solution.dof) : 1;
  if (!report.term.is_constant()) {
    const double squares = spread(design, triangle, column);
    report.vif = solution.root.row(i).squaredNorm() * squares;
    report.contribution_rms =
        std::abs(report.coefficient) * std::sqrt(squares / static_cast<double>(triangle.rows));
  }
  return report;
}

TermReport outside_report(const Design& design, const Selection& selection, int column) {
  TermReport report;
  report.term = design.terms[static_cast<std::size_t>(column)];
  const auto statistics = selection.set.outside(column);
  if (statistics.estimable) {
    report.coefficient = statistics.coefficient;
    report.standard_error = statistics.standard_error;
    report.t = statistics.t;
    report.p = t_two_sided_p(statistics.t, selection.set.dof() - 1);
  } else if (selection.set.collinear(column)) {
    report.note = collinear_sentence(design, selection.set, column);
  } else {
    report.note = "no degrees of freedom left to try it";
  }
  return report;
}

void whole_model_test(const Design& design, const Triangle& triangle, const Solution& solution,
                      Index output, Accuracy& accuracy) {
  const auto y = triangle.outputs.col(output);
  const double total = (design.constant ? y.tail(y.size() - 1).squaredNorm() : y.squaredNorm()) +
                       triangle.beyond[output];
  const auto terms = static_cast<double>(solution.columns.size()) - (design.constant ? 1 : 0);
  if (terms < 1 || solution.dof < 1 || !(solution.rss > 0)) return;
  accuracy.model_f = std::max(0.0, total - solution.rss) / terms / (solution.rss / solution.dof);
  accuracy.model_p = f_upper_p(*accuracy.model_f, terms, solution.dof);
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const auto& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

// Terms outside that would replace one inside at almost no cost: which of the two is in, these data
// did not decide.
void find_replacements(const Design& design, const Selection& selection,
                       std::vector<TermReport>& reports) {
  const auto& chosen = selection.set.order();
  if (chosen.size() > 60 || selection.set.dof() < 2 || selection.exact) return;
  const double limit = selection.set.rss() * 1.01;
  for (const int inside : chosen) {
    if (design.always[static_cast<std::size_t>(inside)] != 0) continue;
    OrthogonalSet without = selection.set;
    without.remove(inside);
    for (int j = 0; j < static_cast<int>(design.terms.size()); ++j) {
      if (selection.set.has(j)) continue;
      const auto statistics = without.outside(j);
      if (!statistics.estimable) continue;
      const double rss =
          std::pow(statistics.standard_error * without.left_over(j), 2) * (without.dof() - 1);
      if (rss <= limit)
        reports[static_cast<std::size_t>(inside)].replaceable_by.push_back(
            effects::notation(design.terms[static_cast<std::size_t>(j)]));
    }
  }
}

}  // namespace

OutputModel describe_output(const Design& design, const Triangle& triangle,
                            const Selection& selection, const Solution& solution, Index output) {
  OutputModel model;
  model.channel = design.outputs[static_cast<std::size_t>(output)];
  model.coefficients = solution.coefficients;
  model.covariance = solution.covariance();
  model.dof = solution.dof;
  for (int column = 0, next = 0; column < static_cast<int>(design.terms.size()); ++column) {
    const bool in = next < static_cast<int>(solution.columns.size()) &&
                    solution.columns[static_cast<std::size_t>(next)] == column;
    if (in) model.terms.push_back(design.terms[static_cast<std::size_t>(column)]);
    model.report.push_back(in ? inside_report(design, triangle, solution, next++)
                              : outside_report(design, selection, column));
  }
  find_replacements(design, selection, model.report);
  int step = 0;
  for (const auto& record : selection.history)
    model.history.push_back({step++, action_name(record.action),
                             record.column < 0
                                 ? effects::Term{}
                                 : design.terms[static_cast<std::size_t>(record.column)],
                             record.p, record.rmse, record.dof, record.value});
  model.accuracy.rmse = solution.dof > 0 ? std::sqrt(solution.rss / solution.dof) : 0;
  model.accuracy.condition_index = condition_index(triangle, solution.columns);
  whole_model_test(design, triangle, solution, output, model.accuracy);
  if (!selection.exact) {
    const auto terms = static_cast<std::int64_t>(solution.columns.size());
    for (const auto& [criterion, value] : {std::pair(Criterion::aic, &model.accuracy.aic),
                                           std::pair(Criterion::bic, &model.accuracy.bic)})
      *value =
          information(solution.rss, triangle.rows, terms, price_per_term(criterion, triangle.rows));
  }
  return model;
}

std::vector<std::string> output_warnings(const Triangle& triangle, const Selection& selection,
                                         const OutputModel& model) {
  std::vector<std::string> warnings;
  const std::string who = model.channel.symbol + ": ";
  if (selection.exact)
    warnings.push_back(
        who + "the terms in reproduce every row to rounding; nothing is left to test others on");
  if (selection.cycled)
    warnings.push_back(who + "selection kept entering and removing the same terms and was stopped");
  for (const auto& report : model.report)
    if (!report.note.empty()) warnings.push_back(who + report.note);
  for (const auto& report : model.report)
    if (!report.replaceable_by.empty())
      warnings.push_back(who + effects::notation(report.term) + " could be replaced by " +
                         joined(report.replaceable_by) +
                         " with less than 1 % more residual variance");
  const auto rows = static_cast<double>(triangle.rows);
  const auto& accuracy = model.accuracy;
  if (accuracy.lag1_autocorrelation > 0.3)
    warnings.push_back(
        who + "successive residuals are correlated (" +
        effects::number_text(std::round(accuracy.lag1_autocorrelation * 100) / 100) + "): about " +
        effects::number_text(std::round(accuracy.effective_rows)) + " of " +
        effects::number_text(rows) +
        " rows are independent; the classical standard errors are too small, see those that "
        "allow for it");
  if (accuracy.condition_index > 1e3)
    warnings.push_back(who + "condition index " +
                       effects::number_text(std::round(accuracy.condition_index)) +
                       ": some terms in nearly add up to others, read their coefficients together");
  if (accuracy.lack_of_fit_p && *accuracy.lack_of_fit_p < 0.01)
    warnings.push_back(who + "lack of fit: repeats agree better than the model fits (F " +
                       effects::number_text(std::round(*accuracy.lack_of_fit_f * 100) / 100) +
                       "), terms are missing");
  return warnings;
}

}  // namespace driftwise::calibration
