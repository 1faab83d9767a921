#include "server/diagnosis/growth/held_out_gate.h"

#include <algorithm>
#include <optional>

#include "server/core/text/quantity_text.h"
#include "server/core/units.h"
#include "server/diagnosis/rows/held_out_gain.h"

namespace driftwise::diagnosis {
namespace {

struct Harm {
  std::size_t index = 0, output = 0;  // of the named
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
    const HeldOutRatio one = held_out_ratio(problem, output, without, extension.described(o));
    if (!one.is_worse() || (worst && one.ratio() <= worst->ratio)) continue;
    const std::string figures = "A90 of " + output.channel.symbol + " " +
                                digits_text(kSigmaToU90 * one.before) + " -> " +
                                digits_text(kSigmaToU90 * one.after) + " " + output.unit;
    worst = {index, o, one.ratio(),
             name_of(causes[extension.named()[index].cause]) +
                 ": with it the rows that took no part in finding it are described worse (" +
                 figures + ")"};
  }
  return worst;
}

// Is a finding worth having for an output other than this one, beyond the interval, and is there
// enough of it without this one to have a name?
bool helps_another(const Problem& problem, const Extension& extension, const Harm& harm) {
  const Ground without = extension.ground(harm.index, extension.shapes());
  if (extension.gain_where_it_acts(harm.index, without, harm.output).gain < kExplainedByOthers)
    return false;
  for (std::size_t o = 0; o < problem.outputs.size(); ++o) {
    if (o == harm.output || extension.named()[harm.index].share[o] == 0) continue;
    const HeldOutRatio one = held_out_ratio(
        problem, problem.outputs[o], extension.described(o, harm.index), extension.described(o));
    if (one.ratio_ci90.high < 1) return true;
  }
  return false;
}

}  // namespace

std::vector<Harmful> withdraw_what_harms(const Problem& problem, const std::vector<Cause>& causes,
                                         Extension& extension, std::vector<std::string>& said) {
  std::vector<Harmful> harmful;
  while (problem.judge.size() >= kFewestJudges && !extension.named().empty()) {
    std::optional<Harm> worst;
    const auto take = [&](std::optional<Harm> harm) {
      if (harm && (!worst || harm->ratio > worst->ratio)) worst = std::move(harm);
    };
    for (std::size_t i = 0; i < extension.named().size(); ++i)
      take(harm_of(problem, causes, extension, i, true));
    const bool alone = worst.has_value();
    if (!worst)  // no one of them, but all together: the weakest goes
      take(harm_of(problem, causes, extension,
                   static_cast<std::size_t>(
                       std::ranges::min_element(extension.named(), {}, &Named::evidence) -
                       extension.named().begin()),
                   false));
    if (!worst) break;
    // A cause need not act on every output: where it helps another it is left out of this one.
    if (alone && extension.named()[worst->index].share[worst->output] > 0 &&
        helps_another(problem, extension, *worst)) {
      said.push_back(worst->sentence + "; it is left out there");
      extension.silence(worst->index, worst->output);
      continue;
    }
    harmful.push_back(
        {extension.named()[worst->index].cause, worst->sentence + " and it was withdrawn"});
    extension.withdraw(worst->index);
  }
  return harmful;
}

double share_left_held_out(const Problem& problem, const Extension& extension) {
  if (problem.judge.size() < kFewestJudges) return 1;
  double before = 0, after = 0;
  for (std::size_t o = 0; o < problem.outputs.size(); ++o) {
    const double noise = extension.noise_sd(o) * extension.noise_sd(o);
    const auto beyond_noise = [&](const SoftBase& base) {
      const Eigen::VectorXd left = judged_residuals(problem, problem.outputs[o], base);
      return std::max(left.squaredNorm() / static_cast<double>(left.size()) / noise - 1, 0.0);
    };
    before += beyond_noise(SoftBase(problem.base_columns));
    after += beyond_noise(extension.described(o));
  }
  return before > 0 ? after / before : 1;
}

}  // namespace driftwise::diagnosis
