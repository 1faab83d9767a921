#pragma once
// The simulation as it grows: the baseline and the causes found so far, each at its best parameter
// given the others.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "server/core/result.h"
#include "server/diagnosis/catalogue/cause.h"
#include "server/diagnosis/catalogue/parameter.h"
#include "server/diagnosis/catalogue/physics.h"
#include "server/diagnosis/growth/told_from_geometry.h"
#include "server/diagnosis/rows/problem.h"
#include "server/diagnosis/search/column_bank.h"
#include "server/diagnosis/search/entry_gate.h"
#include "server/diagnosis/search/search.h"

namespace driftwise::diagnosis {

struct Named {
  std::size_t cause = 0;
  // The parameter's best value with its terms, then what one value leaves: glue that creeps with
  // three time constants, a bearing beside a motor.
  std::vector<Cell> values;
  std::vector<effects::Term> terms;  // of all values
  Eigen::MatrixXd all, learned;      // its columns: every row of the dataset; blocks
  double p_adjusted = 1;             // when it was found
  AmplitudePrior prior;
  double evidence =
      0;  // beyond the baseline and the others: 2 ln of the marginal likelihoods' ratio
  double likelihood = 0;            // growth of 2 ln L
  std::vector<double> share;        // of the prior's width, per output; 0: does not act there
  std::vector<std::string> not_of;  // motors of a coordinate frame that it is left out of
  std::vector<std::size_t> rivals;
};

// Of the best's evidence, before refinement; and the reach of another value of a named cause.
inline constexpr double kWithinReach = 12;

// Evidence of a finding, or gain of one value of it, that the others explain.
inline constexpr double kExplainedByOthers = 8;

// Of a time constant, a width or a period: a continuum of values. One of them is an idealisation of
// what the cause really does.
inline bool has_values(const Cause& cause) {
  return cause.scale == ParameterScale::logarithmic || cause.scale == ParameterScale::inverse;
}
// Of those, and of instants: a cause may have several. Each jump is an event of its own.
inline bool may_repeat(const Cause& cause) {
  return has_values(cause) || cause.scale == ParameterScale::instant;
}

class Extension {
 public:
  // All outlive it.
  Extension(const Problem& problem, const std::vector<Cause>& causes, const Eigen::MatrixXd& series,
            Search& search, const Physics& physics, std::function<bool()> tick);

  const std::vector<Named>& named() const { return named_; }
  // Baseline, what its readings hide and named columns: one row per block, one row per row of the
  // dataset. without: leaves one of the named out. Named columns have their cause's prior.
  SoftBase learned(std::optional<std::size_t> without = {}) const;
  SoftBase all(std::optional<std::size_t> without = {}) const;
  // With the priors of one output, and without what readings hide: what is predicted of it. A cause
  // that these data say does not act there adds nothing. Precisions are those of a fit to the rows
  // as they are. motor: of a frame's coordinates, what they say of this motor; what is not said of
  // it adds nothing.
  SoftBase described(std::size_t output, std::optional<std::size_t> without = {},
                     const std::string& motor = "") const;
  // The same for a fit to whitened rows.
  SoftBase described_whitened(std::size_t output, WhiteSd noise) const;
  // Causes that are not named nor ruled out, and those named that may take a further value of their
  // parameter.
  std::vector<char> allowed() const;

  // Adds the best of a look, its parameter refined; of several that are close before they are
  // refined, the one that is best after. Where one that is named already comes as close with
  // another value of its parameter, that is no new cause: it takes the further value. Where nothing
  // that is near is plausible, those causes are ruled out instead, and so is one that predicts rows
  // worse that it was not fitted to (entry_gate.h). False: nothing was added. Error: stopped.
  Result<bool> add(const Look& look);
  // Two causes where a look finds none beyond chance: one of those that are furthest is supposed,
  // and counts with a second that is beyond chance beside it, where it is so beside the second as
  // well, both together are beyond what the choice among all pairs gives chance, and either passes
  // the gate. False: nothing was added.
  Result<bool> add_two(const Look& look, double alpha);
  // Rules a cause out for good, and takes it back where it is named.
  void forbid(std::size_t cause);
  // Noise of a row by what neighbours differ by, with what is named in the simulation.
  double between_neighbours(std::size_t output) const { return between_neighbours_[output]; }
  // The rows are weighed otherwise than before, so that the noise has another size.
  void weigh_again() {
    if (!named_.empty()) update_noise();
  }
  const std::vector<std::string>& refused() const { return refused_; }  // by the gate: sentences
  // Every parameter again, given the others; then each finding against all other causes: another
  // that does clearly better takes its place, one that the others make superfluous goes, and what
  // comes close is its rival. Says what went. An instant lies at last where the rows in between
  // the learning ones show it.
  Result<std::vector<std::string>> settle();
  void withdraw(std::size_t index);
  // The same, and with it the further values of others that were found beside it.
  Result<void> withdraw_with_its_train(std::size_t index);
  // One of the named adds nothing to what is predicted of this output.
  void silence(std::size_t index, std::size_t output) { named_[index].share[output] = 0; }
  // One of the named is not said of this motor of a coordinate frame.
  void leave_out_of(std::size_t index, const std::string& motor) {
    named_[index].not_of.push_back(motor);
  }
  // Is it? An error of one motor shows in that motor alone.
  bool is_said_of(std::size_t index, const std::string& motor) const;
  // Gain of one of the named where it acts, on the ground without it; but: nor on this output.
  Gain gain_where_it_acts(std::size_t index, const Ground& without,
                          std::optional<std::size_t> but = {}) const;

  // The interval and curve of a finding's parameter, given the others.
  std::optional<Profile> profile_of(std::size_t index) const;
  // Periods that these places, or these instants, cannot tell from a wave's own: what they look
  // like on a lattice, within 6 of the growth of 2 ln L. The longest first.
  std::vector<double> aliases_of(std::size_t index) const;
  // The ground under one of the named, or under what would come next.
  Ground ground(std::optional<std::size_t> without, const std::vector<NoiseShape>& shapes) const;
  const std::vector<NoiseShape>& shapes() const { return shapes_; }

 private:
  struct Candidate {
    std::size_t cause = 0;
    Refined refined;
    double evidence = -1e300;  // averaged over the parameter
    double beyond = -1e300;    // the same over what chance gives this cause
    Gain gain;
    std::vector<effects::Term> terms;
    AmplitudePrior prior;
    bool nameable = true;  // false: geometry does as well, so that it can be a rival only
  };
  SoftBase with_named(SoftBase base, std::optional<std::size_t> without) const;
  // precision_of: of an amplitude with a prior of this standard deviation.
  SoftBase described_by(std::size_t output, const std::function<double(double)>& precision_of,
                        std::optional<std::size_t> without, const std::string& motor) const;
  Candidate refined(std::size_t cause, const Standing& standing, const Ground& ground) const;
  // values: of the parameter, the one at `at` to be tried.
  GainOf gain_of(const Ground& ground, const Cause& cause, std::vector<Cell> values,
                 std::size_t at) const;
  // Those within reach of the first, and these, refined: what can be named first, then the best.
  std::vector<Candidate> contenders(const Look& look, const Ground& ground,
                                    const std::vector<std::size_t>& present) const;
  Result<bool> add_beside(std::size_t cause, const Look& look, double alpha);
  // base: what `ground` stands on.
  GateScore gate_score(const Candidate& candidate, const Ground& ground,
                       const SoftBase& base) const;
  Result<Named> made(const Candidate& candidate, double p_adjusted) const;
  std::optional<std::size_t> index_of(std::size_t cause) const;  // among the named
  // Another value of its parameter for one of the named.
  Result<void> add_value(std::size_t index, const Candidate& candidate);
  Result<void> set_values(Named& named, std::vector<Cell> values) const;
  Result<void> reoptimise();
  Result<void> leave_superfluous_values(Named& named);
  void update_noise();
  Candidate as_it_stands(std::size_t index, const Standing& standing, const Ground& ground) const;
  std::optional<std::vector<Candidate>> stand_ins(std::size_t index);
  std::optional<std::size_t> value_of_another(std::size_t index,
                                              const std::vector<Candidate>& best) const;
  double wherever_it_acts(const std::string& id, const std::vector<Candidate>& best) const;
  std::size_t preferred(const std::vector<Candidate>& best, const Ground& ground) const;
  static bool before(const Candidate& a, const Candidate& b);
  bool comes_near(const Candidate& candidate, const Candidate& best) const;
  Candidate of_cell(std::size_t cause, std::size_t cell, const Standing& standing,
                    const Ground& ground) const;
  // No amplitude is beyond the cause's range by more than twice its standard error.
  bool within_range(const Candidate& candidate, const Eigen::MatrixXd& columns,
                    const Ground& ground) const;
  // Likelihood that the strongest of the causes with values may leave, and its name.
  struct Misfit {
    double likelihood = -1e300;
    std::string of;
  };
  Misfit misfit() const;
  void leave_misfits(std::vector<std::string>& said);
  Result<void> place_instants();
  Result<void> take_own_widths();
  Result<void> place_instant(std::size_t index, std::size_t value);
  Result<void> move_instant(std::size_t index, std::size_t value, double instant_s);
  void name_rivals(std::size_t index, const std::vector<Candidate>& best, std::size_t first);

  const Problem& problem_;
  const std::vector<Cause>& causes_;
  const Eigen::MatrixXd& series_;
  Search& search_;
  std::function<bool()> tick_;
  std::vector<double> instants_;
  std::vector<NoiseShape> shapes_;
  const Physics& physics_;
  ToldFromGeometry told_from_geometry_;
  EntryGate gate_;
  std::vector<double> between_neighbours_;
  std::vector<WhiteSd> white_sd_;
  std::vector<char> ruled_out_, forbidden_;
  std::vector<std::string> refused_;
  std::vector<Named> named_;
};

}  // namespace driftwise::diagnosis
