#pragma once
// Tails of what is left: a Student law alone, or beside it a few gross errors of
// a size of their own. Both by expectation and maximisation, for each of some degrees of freedom.

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

namespace driftwise::diagnosis {

class Tails {
 public:
  static constexpr std::array<double, 7> kFreedoms = {2, 3, 4, 6, 10, 20, 1000};
  // left: of every row, any unit.
  explicit Tails(const Eigen::VectorXd& left);
  // Log-likelihood, of the degrees of freedom with this number.
  double one_law(std::size_t freedom) const { return one_law_[freedom].log_likelihood; }
  double two_laws(std::size_t freedom) const { return two_laws_[freedom].log_likelihood; }
  // Square of the Student law's scale, alone.
  double square(std::size_t freedom) const { return one_law_[freedom].square; }
  // Posterior of being a gross error, of every row.
  const Eigen::ArrayXd& gross(std::size_t freedom) const { return two_laws_[freedom].gross; }

 private:
  struct Fit {
    double log_likelihood = -1e300, square = 1;
    Eigen::ArrayXd gross;
  };
  Fit fit(double freedom, bool with_gross) const;

  Eigen::ArrayXd square_;
  double start_ = 1;
  std::array<Fit, kFreedoms.size()> one_law_, two_laws_;
};

// The outputs of a robot. The same instruments read all of them in the same air, so that their
// tails have one shape, as their noise has; an output's own costs as much (kOwnShape).
struct CommonTails {
  std::size_t freedom = 0;  // of Tails::kFreedoms, the likeliest of all outputs together
  double gain = 0;          // 2 ln L over normal noise
};
CommonTails common_tails(const std::vector<Tails>& outputs);

struct GrossGain {
  double gain = 0;  // 2 ln L, with gross errors on one output to without any
  std::size_t freedom = 0;
};
GrossGain gross_gain(const std::vector<Tails>& outputs, std::size_t output);

// Share of the drawn gains that chance_of_gross() takes for the tail: no smaller gain than 2 ln
// (this / p) has the chance p.
inline constexpr double kTailFrom = 0.1;

// Chance of such a gain on any output where all rows of all outputs follow one Student law: from
// rows drawn so, what nine in ten of them keep below, and from there on a tail like exp(-x / 2),
// that of a ratio of likelihoods.
double chance_of_gross(const std::vector<Tails>& outputs, Eigen::Index rows, double gain);

}  // namespace driftwise::diagnosis
