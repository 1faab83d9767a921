#pragma once
// Nothing enters that predicts worse: a cause is held against rows of the calibration that it was
// not fitted to, by contiguous blocks of time and by groups of neighbouring places. In each fold
// its parameter is weighed again over its whole grid, and amplitudes and baseline are fitted again,
// under their priors. The score is the growth of twice the log of the predictive density of the
// whitened rows left out: over the outputs that the cause acts on together, averaged over the
// parameter.
//
// Beside the test against nulls, never in its place. An event (a jump at one instant) cannot be
// predicted from other blocks: every second short block is left out, and what is predicted is the
// level on each side.

#include <optional>
#include <vector>

#include "server/diagnosis/catalogue/cause.h"
#include "server/diagnosis/noise/ground.h"
#include "server/diagnosis/rows/problem.h"
#include "server/diagnosis/search/scan.h"

namespace driftwise::diagnosis {

struct GateScore {
  std::optional<double> by_time, by_places;  // 2 ln; nothing: could not be asked
  bool passes() const { return by_time.value_or(1) > 0 && by_places.value_or(1) > 0; }
};

class EntryGate {
 public:
  // All outlive it. series: blocks x outputs, as for the search.
  EntryGate(const Problem& problem, const Eigen::MatrixXd& series, const Bank& bank);

  // base: of what stands; noise: one shape per output; sd: of the white noise, per output.
  GateScore judge(const SoftBase& base, const std::vector<NoiseShape>& noise,
                  const std::vector<double>& sd, const Cause& cause, std::size_t entry) const;

 private:
  struct Fold {
    std::vector<Eigen::Index> out;   // predicted
    std::vector<Eigen::Index> idle;  // neither predicted nor learned from: the gap
  };
  double score(const std::vector<Fold>& folds, const SoftBase& base,
               const std::vector<NoiseShape>& noise, const std::vector<double>& sd,
               std::size_t entry) const;
  std::vector<Fold> time_folds(double gap_s) const;
  std::vector<Fold> alternating_folds() const;

  const Problem& problem_;
  const Eigen::MatrixXd& series_;
  const Bank& bank_;
  std::vector<Fold> place_folds_;  // empty: too few places
};

}  // namespace driftwise::diagnosis
