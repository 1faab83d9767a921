#pragma once
// The simulation as it grows: the baseline and the causes found so far, each at its best parameter
// given the others.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "server/core/result.h"
#include "server/diagnosis/cause.h"
#include "server/diagnosis/column_bank.h"
#include "server/diagnosis/parameter.h"
#include "server/diagnosis/problem.h"
#include "server/diagnosis/search.h"

namespace driftwise::diagnosis {

struct Named {
  std::size_t cause = 0;
  std::vector<effects::Term> terms;  // at the parameter's best value
  double parameter = 0;
  Eigen::MatrixXd all, learned;  // its columns: every row of the dataset; blocks
  double p_adjusted = 1;         // when it was found
  double gain = 0, ln_p = 0;     // beyond the baseline and the others
  std::vector<std::size_t> rivals;
};

class Extension {
 public:
  // All outlive it.
  Extension(const Problem& problem, const std::vector<Cause>& causes, const Eigen::MatrixXd& series,
            Search& search, std::function<bool()> tick);

  const std::vector<Named>& named() const { return named_; }
  // Baseline and named columns: one row per block, one row per row of the dataset. without: leaves
  // one of the named out.
  Eigen::MatrixXd learned(std::optional<std::size_t> without = {}) const;
  Eigen::MatrixXd all(std::optional<std::size_t> without = {}) const;
  std::vector<char> allowed() const;  // causes that are not named

  // Adds the best of a look, its parameter refined; of several that are close before they are
  // refined, the one that is best after. Nothing: stopped.
  Result<void> add(const Look& look);
  // Every parameter again, given the others; then each finding against all other causes: another
  // that does clearly better takes its place, one that the others make superfluous goes, and what
  // comes close is its rival. Says what went.
  Result<std::vector<std::string>> settle();
  void withdraw(std::size_t index);

  // The interval and curve of a finding's parameter, given the others.
  std::optional<Profile> profile_of(std::size_t index) const;
  // The ground under one of the named, or under what would come next.
  Ground ground(std::optional<std::size_t> without, const std::vector<NoiseShape>& shapes) const;
  const std::vector<NoiseShape>& shapes() const { return shapes_; }

 private:
  struct Candidate {
    std::size_t cause = 0;
    Refined refined;
    double ln_p = 0;
    Gain gain;
    std::vector<effects::Term> terms;
  };
  Candidate refined(std::size_t cause, std::size_t cell, const Ground& ground) const;
  GainOf gain_of(const Ground& ground, const Cause& cause,
                 const std::vector<effects::Term>& terms) const;
  // Those within reach of the first, refined, the best first.
  std::vector<Candidate> contenders(const Look& look, const Ground& ground,
                                    std::optional<std::size_t> present) const;
  Result<Named> made(const Candidate& candidate, double p_adjusted) const;
  Result<void> reoptimise();

  const Problem& problem_;
  const std::vector<Cause>& causes_;
  const Eigen::MatrixXd& series_;
  Search& search_;
  std::function<bool()> tick_;
  std::vector<double> instants_;
  std::vector<NoiseShape> shapes_;
  std::vector<Named> named_;
};

}  // namespace driftwise::diagnosis
