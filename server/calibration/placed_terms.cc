#include "server/calibration/placed_terms.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "server/calibration/design/design.h"
#include "server/calibration/design/predict.h"
#include "server/core/try.h"
#include "server/effects/term_order.h"

namespace driftwise::calibration {
namespace {

using Eigen::Index;

void refresh_report(OutputModel& output) {
  Index in = 0;
  for (auto& report : output.report) {
    if (!report.in) continue;
    report.coefficient = output.coefficients[in];
    report.standard_error = std::sqrt(output.covariance(in, in));
    if (output.covariance_serial.size() > 0)
      report.standard_error_serial = std::sqrt(output.covariance_serial(in, in));
    ++in;
  }
}

// Into the constant, with its uncertainty; value: of the term, that stays.
void settle(const effects::Term& term, double value, OutputModel& output) {
  const auto at = std::ranges::find(output.terms, term) - output.terms.begin();
  const auto constant = std::ranges::find(output.terms, effects::Term{}) - output.terms.begin();
  const Index n = output.coefficients.size();
  if (at == n || constant == n) return;
  Eigen::MatrixXd to = Eigen::MatrixXd::Identity(n, n);  // coefficients as they stay
  to(constant, at) = value;
  std::vector<Index> kept;
  for (Index k = 0; k < n; ++k)
    if (k != at) kept.push_back(k);
  const Eigen::MatrixXd rows = to(kept, Eigen::all);
  output.coefficients = Eigen::VectorXd(rows * output.coefficients);
  output.covariance = Eigen::MatrixXd(rows * output.covariance * rows.transpose());
  if (output.covariance_serial.size() > 0)
    output.covariance_serial = Eigen::MatrixXd(rows * output.covariance_serial * rows.transpose());
  if (output.covariance_root.size() > 0) {
    const Eigen::MatrixXd root = rows * output.covariance_root;  // one row fewer: made square again
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(root.transpose());
    output.covariance_root = Eigen::MatrixXd(qr.matrixQR().topRows(root.rows()).transpose())
                                 .triangularView<Eigen::Lower>();
  }
  for (auto& influence : output.influences)
    influence.shift = Eigen::VectorXd(rows * influence.shift);
  output.terms.erase(output.terms.begin() + at);
  std::erase_if(output.report, [&](const TermReport& one) { return one.term == term; });
  refresh_report(output);
}

}  // namespace

Result<Model> fit_placed(const Dataset& dataset, FitOptions options, std::vector<PlacedTerm> placed,
                         const std::string& formula) {
  auto& offered = options.candidates.terms;
  for (auto& one : placed) one.term = effects::canonical(one.term);
  std::erase_if(placed, [&](const PlacedTerm& one) {
    return std::ranges::any_of(
        offered, [&](const effects::Term& term) { return effects::canonical(term) == one.term; });
  });
  for (const auto& one : placed) {
    if (std::ranges::find(offered, one.term) != offered.end()) continue;
    offered.push_back(one.term);
    if (!options.hierarchy) options.forced.push_back(one.term);
  }
  options.candidates.formula = formula;
  DRIFTWISE_TRY(auto model, fit(dataset, options, placed));
  for (const auto& one : placed) {
    if (!one.stays) continue;
    DRIFTWISE_TRY(const auto columns, raw_columns(dataset, {one.term}));
    DRIFTWISE_TRY(const auto design, make_design(dataset, options));
    for (auto& output : model.outputs)
      settle(one.term, columns(static_cast<Index>(design.rows.back()), 0), output);
  }
  return model;
}

}  // namespace driftwise::calibration
