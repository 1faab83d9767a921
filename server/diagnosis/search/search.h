#pragma once
// The search for one more cause on top of a simulation, with the chance that noise does as well.

#include <functional>
#include <optional>
#include <vector>

#include "server/diagnosis/noise/ground.h"
#include "server/diagnosis/search/chance.h"
#include "server/diagnosis/search/scan.h"

namespace driftwise::diagnosis {

// Of one cause. Every cause has the same share of alpha: its prior odds are such that chance gives
// each of them a name as often. A cause whose prior is a thousand times wider than what there is to
// be found would otherwise have to be seen far better than its neighbours to be named at all.
struct Standing {
  // 2 ln of the marginal likelihood's ratio, averaged over its cells, beyond what the largest of
  // chance's is located at.
  double evidence = -1e300;
  double gain = -1e300;  // of its best cell
  std::size_t cell = 0;
  // What the average over the parameter takes from the best value's gain, and more.
  double occam() const { return evidence - gain; }
};

struct Look {
  std::vector<Standing> causes;      // one per entry of the bank
  std::optional<std::size_t> first;  // the cause with the largest evidence
  double p_adjusted = 1;             // of it, for the search over all of them
  int nulls = 0;
  std::vector<NoiseShape> shapes;  // that were in question
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

 private:
  std::vector<NoiseShape> shapes_in_question(const SoftBase& base, const std::vector<char>& allowed,
                                             bool& stopped) const;
  const Timeline& timeline_;
  const Eigen::MatrixXd& series_;
  Bank bank_;
  SearchOptions options_;
  std::vector<NoiseShape> grid_;
  std::vector<double> of_chance_;  // per cause: location of the nulls' evidence, last look
  EvidenceTail tail_;              // of the last look
};

}  // namespace driftwise::diagnosis
