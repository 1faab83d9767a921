#include "server/diagnosis/held_out_gate.h"

#include <optional>

#include "server/core/quantity_text.h"
#include "server/diagnosis/held_out_gain.h"

namespace driftwise::diagnosis {
namespace {

constexpr std::size_t kFewestJudges = 20;

struct Harm {
  std::size_t index = 0;  // of the named
  double ratio = 1;       // lower end of A90 with it, to A90 without it
  std::string sentence;
};

std::optional<Harm> harm_of(const Problem& problem, const std::vector<Cause>& causes,
                            const Extension& extension, std::size_t index) {
  const Cause& cause = causes[extension.named()[index].cause];
  if (cause.scale == ParameterScale::instant) return std::nullopt;
  const auto on = acts_on(problem, cause);
  const Eigen::MatrixXd without = extension.all(index), with = extension.all();
  std::optional<Harm> worst;
  for (std::size_t o = 0; o < problem.outputs.size(); ++o) {
    if (on[o] == 0) continue;
    const auto& output = problem.outputs[o];
    const HeldOut held = held_out(problem, output, without, with);
    const double ratio = held.a90_after_ci90.low / held.before.a90;
    if (!(ratio > 1) || (worst && ratio <= worst->ratio)) continue;
    const std::string figures = "A90 of " + output.channel.symbol + " " +
                                digits_text(held.before.a90) + " -> " +
                                digits_text(held.after.a90) + " " + output.unit;
    worst = {index, ratio,
             name_of(cause) +
                 " was withdrawn: with it the rows that took no part in finding it "
                 "are described worse (" +
                 figures + ")"};
  }
  return worst;
}

}  // namespace

std::vector<std::string> withdraw_what_harms(const Problem& problem,
                                             const std::vector<Cause>& causes,
                                             Extension& extension) {
  std::vector<std::string> said;
  while (problem.judge.size() >= kFewestJudges) {
    std::optional<Harm> worst;
    for (std::size_t i = 0; i < extension.named().size(); ++i)
      if (auto harm = harm_of(problem, causes, extension, i);
          harm && (!worst || harm->ratio > worst->ratio))
        worst = std::move(harm);
    if (!worst) break;
    said.push_back(std::move(worst->sentence));
    extension.withdraw(worst->index);
  }
  return said;
}

}  // namespace driftwise::diagnosis
