#include "server/diagnosis/held_out_gate.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "server/core/text/quantity_text.h"
#include "server/core/units.h"
#include "server/diagnosis/held_out_gain.h"

namespace driftwise::diagnosis {
namespace {

constexpr std::size_t kFewestJudges = 20, kBlocks = 20;
constexpr double kWorse = 1.02, kOneSided90 = 1.645;

struct Compared {
  double before = 0, after = 0;  // root mean squares of the judging rows
  double ratio_low = 0;          // lower end of the ratio's 90 % interval
};

double ratio_of(const Eigen::VectorXd& before, const Eigen::VectorXd& after) {
  return 0.5 * std::log(after.squaredNorm() / std::max(before.squaredNorm(), 1e-300));
}

// Jackknife over contiguous blocks of the ratio itself: what both share cancels.
Compared compared(const Problem& problem, const ProblemOutput& output, const SoftBase& without,
                  const SoftBase& with) {
  const Eigen::VectorXd before = judged_residuals(problem, output, without);
  const Eigen::VectorXd after = judged_residuals(problem, output, with);
  const auto n = static_cast<std::size_t>(before.size());
  Compared result{std::sqrt(before.squaredNorm() / static_cast<double>(n)),
                  std::sqrt(after.squaredNorm() / static_cast<double>(n)), 0};
  const std::size_t blocks = std::min(kBlocks, n / 4);
  std::vector<double> left_out;
  for (std::size_t k = 0; k < blocks; ++k) {
    std::vector<std::size_t> kept;
    for (std::size_t i = 0; i < n; ++i)
      if (i * blocks / n != k) kept.push_back(i);
    left_out.push_back(ratio_of(rows_of(before, kept), rows_of(after, kept)));
  }
  double mean = 0, squares = 0;
  const auto count = static_cast<double>(blocks);
  for (const double one : left_out) mean += one / count;
  for (const double one : left_out) squares += (one - mean) * (one - mean);
  const double error = std::sqrt(squares * (count - 1) / count);
  result.ratio_low = std::exp(ratio_of(before, after) - kOneSided90 * error);
  return result;
}

struct Harm {
  std::size_t index = 0;  // of the named
  double ratio = 1;
  std::string sentence;
};

// index: the finding that is to go if the comparison is bad. only: compared with the
// others in, else with none.
std::optional<Harm> harm_of(const Problem& problem, const std::vector<Cause>& causes,
                            const Extension& extension, std::size_t index, bool only) {
  std::optional<Harm> worst;
  for (std::size_t o = 0; o < problem.outputs.size(); ++o) {
    const auto& output = problem.outputs[o];
    const SoftBase without = only ? extension.described(o, index) : SoftBase(problem.base_columns);
    const Compared one = compared(problem, output, without, extension.described(o));
    const double ratio = one.after / std::max(one.before, 1e-300);
    if (!(ratio > kWorse) || !(one.ratio_low > 1) || (worst && ratio <= worst->ratio)) continue;
    const std::string figures = "A90 of " + output.channel.symbol + " " +
                                digits_text(kSigmaToU90 * one.before) + " -> " +
                                digits_text(kSigmaToU90 * one.after) + " " + output.unit;
    worst = {index, ratio,
             name_of(causes[extension.named()[index].cause]) +
                 " was withdrawn: with it the rows that took no part in finding it "
                 "are described worse (" +
                 figures + ")"};
  }
  return worst;
}

}  // namespace

std::vector<Harmful> withdraw_what_harms(const Problem& problem, const std::vector<Cause>& causes,
                                         Extension& extension) {
  std::vector<Harmful> harmful;
  while (problem.judge.size() >= kFewestJudges && !extension.named().empty()) {
    std::optional<Harm> worst;
    const auto take = [&](std::optional<Harm> harm) {
      if (harm && (!worst || harm->ratio > worst->ratio)) worst = std::move(harm);
    };
    for (std::size_t i = 0; i < extension.named().size(); ++i)
      take(harm_of(problem, causes, extension, i, true));
    if (!worst)  // no one of them, but all together: the weakest goes
      take(harm_of(problem, causes, extension,
                   static_cast<std::size_t>(
                       std::ranges::min_element(extension.named(), {}, &Named::evidence) -
                       extension.named().begin()),
                   false));
    if (!worst) break;
    harmful.push_back({extension.named()[worst->index].cause, std::move(worst->sentence)});
    extension.withdraw(worst->index);
  }
  return harmful;
}

}  // namespace driftwise::diagnosis
