#pragma once
// What a finding is worth on rows that played no part in finding it.

#include <Eigen/Core>
#include <vector>

#include "server/core/data/accuracy.h"
#include "server/diagnosis/answer/finding.h"
#include "server/diagnosis/noise/soft_base.h"
#include "server/diagnosis/rows/problem.h"

namespace driftwise::diagnosis {

// Judging rows from which a held-out figure decides anything.
inline constexpr std::size_t kFewestJudges = 20;

struct HeldOut {
  ErrorFigures before, after;               // of the judging rows
  Interval u90_after_ci90, a90_after_ci90;  // over blocks of them
};

// Each fold fitted by least squares (with the prior of the amplitudes that have one) and judged on
// its own rows. before, after: every row of the dataset, the columns of the two simulations.
HeldOut held_out(const Problem& problem, const ProblemOutput& output, const SoftBase& before,
                 const SoftBase& after);
// The same of what two simulations leave of the judging rows.
HeldOut held_out(const Eigen::VectorXd& before, const Eigen::VectorXd& after);

// Root mean squares of the judging rows, mean included, of two simulations.
struct HeldOutRatio {
  double before = 0, after = 0;
  Interval ratio_ci90{};  // of after over before: over blocks of the rows
  double ratio() const { return before > 0 ? after / before : 1; }
  // By more than 2 % and beyond the interval: with this a simulation is not offered.
  bool is_worse() const { return ratio() > 1.02 && ratio_ci90.low > 1; }
};
HeldOutRatio held_out_ratio(const Problem& problem, const ProblemOutput& output,
                            const SoftBase& before, const SoftBase& after);
// The same of what two simulations leave of the judging rows.
HeldOutRatio held_out_ratio(const Eigen::VectorXd& before, const Eigen::VectorXd& after);
// Of several outputs, stacked, `rows` of each: of all together, each in units of what `before`
// leaves.
HeldOutRatio held_out_ratio_together(const Eigen::VectorXd& before, const Eigen::VectorXd& after,
                                     std::size_t rows);
// The largest such ratio, of one output or of all together, that is worse; 0: none is, or there are
// too few to say.
double harm(const Eigen::VectorXd& before, const Eigen::VectorXd& after, std::size_t rows);

// Residuals of the rows of `judge`, each from the fit that did not see it.
Eigen::VectorXd judged_residuals(const Problem& problem, const ProblemOutput& output,
                                 const SoftBase& base);

// Residuals of every row of the dataset, from a fit to the learning rows; NaN where columns are.
Eigen::VectorXd residuals(const Problem& problem, const ProblemOutput& output,
                          const SoftBase& base);

// The same of the readings as they were, with what the search freed them of; so are all figures.
Eigen::VectorXd residuals_as_read(const Problem& problem, const ProblemOutput& output,
                                  const SoftBase& base);

}  // namespace driftwise::diagnosis
