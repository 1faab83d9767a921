#include "server/diagnosis/growth/held_out_gate.h"

#include <algorithm>
#include <optional>

#include "server/core/text/quantity_text.h"
#include "server/core/units.h"
#include "server/diagnosis/rows/held_out_gain.h"

namespace driftwise::diagnosis {
namespace {

constexpr std::size_t kFewestJudges = 20;

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
    const HeldOutRatio one = held_out_ratio(problem, output, without, extension.described(o));
    if (!one.is_worse() || (worst && one.ratio() <= worst->ratio)) continue;
    const std::string figures = "A90 of " + output.channel.symbol + " " +
                                digits_text(kSigmaToU90 * one.before) + " -> " +
                                digits_text(kSigmaToU90 * one.after) + " " + output.unit;
    worst = {index, one.ratio(),
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
