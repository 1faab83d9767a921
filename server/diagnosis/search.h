#pragma once
// The search for one more cause on top of a simulation, with the chance that noise does as well.

#include <functional>
#include <optional>
#include <vector>

#include "server/diagnosis/chance.h"
#include "server/diagnosis/ground.h"
#include "server/diagnosis/scan.h"

namespace driftwise::diagnosis {

struct Standing {  // of one cause
  double gain = 0;
  std::size_t cell = 0;
  double ln_p = 0;  // of one look at this cause alone: 0 where it gains nothing
};

struct Look {
  std::vector<Standing> causes;      // one per entry of the bank
  std::optional<std::size_t> first;  // the cause that chance imitates least
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

  // base: blocks x k. Draws 49 series of noise and, where the answer is not clear, the rest.
  // Nothing: stopped.
  std::optional<Look> look(const Eigen::MatrixXd& base, const std::vector<char>& allowed);
  // Without a new look at chance: standings by the nulls of the last look().
  std::optional<Look> compare(const Eigen::MatrixXd& base, const std::vector<char>& allowed) const;

  // ln p of another gain of a cause, by the nulls of the last look().
  double ln_p(std::size_t cause, double gain, int dof) const;
  const Bank& bank() const { return bank_; }

 private:
  std::vector<NoiseShape> shapes_in_question(const Eigen::MatrixXd& base,
                                             const std::vector<char>& allowed, bool& stopped) const;
  void fit_tails(const std::vector<std::vector<Best>>& best, std::size_t nulls,
                 const std::vector<char>& allowed);

  const Timeline& timeline_;
  const Eigen::MatrixXd& series_;
  Bank bank_;
  SearchOptions options_;
  std::vector<NoiseShape> grid_;
  std::vector<NullTail> tails_;  // of each cause when it was last looked for
};

}  // namespace driftwise::diagnosis
