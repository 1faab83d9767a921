#pragma once
// The physics of the catalogue (docs/diagnosis.md has the table): how large each cause's amplitude
// typically is, how large it can be. Evidence for a cause is its marginal likelihood under the
// Gaussian prior N(0, typical^2); an amplitude beyond the range is not that cause.
//
// A cell narrows a prior by what it declares (lever arms: lever_limits.h); a file from anywhere has
// the wide default.

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "server/diagnosis/answer/lever_limits.h"
#include "server/diagnosis/catalogue/cause.h"
#include "server/diagnosis/noise/white_sd.h"
#include "server/diagnosis/rows/problem.h"

namespace driftwise::diagnosis {

struct AmplitudePrior {
  // terms x outputs, summary unit of the output per unit of the term. 0: the cause does not act
  // there.
  Eigen::MatrixXd typical, range;
};

// Of the rows' noise, from what neighbours in time differ by after a least-squares fit of these
// columns (every row of the dataset): a slow effect is hardly in it. Summary unit.
double noise_between_neighbours(const Problem& problem, std::size_t output,
                                const Eigen::MatrixXd& columns);

class Physics {
 public:
  // problem outlives it.
  Physics(const Problem& problem, const std::optional<LeverLimits>& levers);

  // columns: of the terms, one row per block.
  AmplitudePrior prior(const Cause& cause, const std::vector<effects::Term>& terms,
                       double parameter, const Eigen::Ref<const Eigen::MatrixXd>& columns) const;
  // Precision of whitened rows for columns of the simulation that all outputs share: the geometric
  // mean over the outputs where the cause acts.
  // prior_sd: columns x outputs; 0: does not act. noise: per output, with what is named in the
  // simulation.
  static Eigen::VectorXd shared_precision(const Eigen::MatrixXd& prior_sd,
                                          const std::vector<WhiteSd>& noise);
  double between_neighbours(std::size_t output) const { return between_neighbours_[output]; }
  // Of a shape that no physics describes: half the standard deviation of the noise at its largest.
  Eigen::MatrixXd of_free_shape(const Eigen::Ref<const Eigen::MatrixXd>& columns) const;

 private:
  double range_of(const std::string& symbol) const;
  double nm_per_ppm(const effects::Term& term, std::size_t output) const;
  double per_unit_at_the_end(const effects::Term& term,
                             const std::vector<std::string>& symbols) const;
  double of_first_order(const effects::Term& term) const;
  double nm_per_unit(const Cause& cause, const effects::Term& term, double parameter,
                     double column_range, std::size_t output) const;
  double range_factor(const Cause& cause, const effects::Term& term, std::size_t output) const;

  const Problem& problem_;
  std::optional<LeverLimits> levers_;
  double longest_stroke_mm_ = 0, hours_ = 0, force_range_ = 0;
  std::vector<double> between_neighbours_;  // noise, summary units
  Eigen::MatrixXd slopes_;  // outputs x 3, nm per mm of x y z; 0 where an axis does not vary
};

}  // namespace driftwise::diagnosis
