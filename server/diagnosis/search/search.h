#pragma once
// The search for one more cause on top of a simulation, with the chance that noise does as well.

#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "server/diagnosis/noise/ground.h"
#include "server/diagnosis/search/chance.h"
#include "server/diagnosis/search/scan.h"

namespace driftwise::diagnosis {

// Of one cause. Whether anything is there is asked of `beyond`: every cause has the same share of
// alpha, so that one whose prior is a thousand times wider than what there is to be found need not
// be seen far better than its neighbours. Which of them it is goes by `evidence`.
struct Standing {
  // 2 ln of the marginal likelihood's ratio, averaged over its cells.
  double evidence = -1e300;
  double beyond = -1e300;  // the same less what the largest of chance's is located at
  double gain = -1e300;    // of its best cell
  std::size_t cell = 0;
  // What the average over the parameter takes from the best value's gain.
  double occam() const { return evidence - gain; }
  double over_chance() const { return beyond - evidence; }
};

struct Look {
  std::vector<Standing> causes;  // one per entry of the bank
  // Of the causes that chance does not explain the one with the largest evidence; where chance
  // explains them all, the one that is furthest beyond it.
  std::optional<std::size_t> first;
  double p_adjusted = 1;  // of it, for the search over all of them
  int nulls = 0;
  std::vector<NoiseShape> shapes;  // that were in question
  EvidenceTail tail;               // of chance, for what is beyond it
};

struct SearchOptions {
  int nulls = 199;
  double alpha = 0.003;
  std::uint64_t seed = 1;
  calibration::Executor executor;
  std::function<bool()> tick;  // false: stop
};

class Search {
 public:
  // timeline and series (blocks x outputs) outlive it.
  Search(const Timeline& timeline, const Eigen::MatrixXd& series, Bank bank, SearchOptions options);

  // base: rows x k. Draws 49 series of noise and, where the answer is not clear, the rest.
  // Nothing: stopped.
  std::optional<Look> look(const SoftBase& base, const std::vector<char>& allowed);
  // Without a look at chance.
  // p_adjusted: by the nulls of the last look(), which was at the same base or a smaller one.
  std::optional<Look> compare(const SoftBase& base, const std::vector<char>& allowed) const;

  const Bank& bank() const { return bank_; }

  // Of the last look(); compare() goes by it.
  struct Chance {
    std::vector<double> of_cause;  // location of the nulls' evidence
    EvidenceTail tail;
  };
  const Chance& chance() const { return chance_; }
  void set_chance(Chance chance) { chance_ = std::move(chance); }

 private:
  std::vector<NoiseShape> shapes_in_question(const SoftBase& base, const std::vector<char>& allowed,
                                             bool& stopped) const;
  void choose_first(Look& look) const;
  const Timeline& timeline_;
  const Eigen::MatrixXd& series_;
  Bank bank_;
  SearchOptions options_;
  std::vector<NoiseShape> grid_;
  Chance chance_;
};

}  // namespace driftwise::diagnosis
