#include "server/diagnosis/growth/correction_reach.h"

#include <algorithm>
#include <cmath>

#include "server/core/units.h"
#include "server/correction/first_conditions.h"
#include "server/diagnosis/search/column_bank.h"
#include "server/effects/term_order.h"

namespace driftwise::diagnosis {

std::optional<CorrectionReach> correction_reach(const Problem& problem,
                                                const std::vector<effects::Term>& terms,
                                                const WeightedFit& fit) {
  Eigen::MatrixXd counted(problem.timeline.rows(), static_cast<Eigen::Index>(terms.size()));
  for (std::size_t k = 0; k < terms.size(); ++k) {
    std::vector<effects::Term> parts = {terms[k]};
    std::vector<double> weights = {1};
    if (!correction::count_from_first(problem.data(), parts, weights)) return std::nullopt;
    const auto columns = filled_columns(problem, parts);
    if (!columns) return std::nullopt;
    Eigen::VectorXd column =
        problem.learned(*columns) * Eigen::Map<const Eigen::VectorXd>(
                                        weights.data(), static_cast<Eigen::Index>(weights.size()));
    if (!std::ranges::any_of(effects::symbols_of(terms[k]), is_pose_symbol))
      column.array() -= column[0];  // a length is 0 where it was zeroed, whatever the air was
    counted.col(static_cast<Eigen::Index>(k)) = column;
  }
  CorrectionReach reach;
  reach.u90 = kSigmaToU90 * fit.added_spread(counted);
  if (!std::isfinite(reach.u90)) return std::nullopt;
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(counted.rows());
  for (Eigen::Index k = 0; k < counted.cols(); ++k)
    sum += fit.added_coefficient(k) * counted.col(k);
  reach.rms = std::sqrt(sum.squaredNorm() / static_cast<double>(sum.size()));
  return reach;
}

}  // namespace driftwise::diagnosis
