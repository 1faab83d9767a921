#include "server/diagnosis/growth/held_out_gate.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "server/core/text/quantity_text.h"
#include "server/core/units.h"
#include "server/diagnosis/growth/motors_as_served.h"
#include "server/diagnosis/rows/held_out_gain.h"

namespace driftwise::diagnosis {
namespace {

struct Harm {
  std::size_t index = 0;              // of the named
  std::optional<std::size_t> output;  // nothing: a motor, which several of them are behind
  std::optional<std::size_t> motor;   // of a coordinate frame
  double ratio = 1;
  std::string sentence;
};

Harm harm_to(const ProblemOutput& output, const Cause& cause, std::size_t index,
             const HeldOutRatio& one) {
  return {index,
          {},
          {},
          one.ratio(),
          name_of(cause) +
              ": with it the rows that took no part in finding it are described worse (A90 of " +
              output.channel.symbol + " " + digits_text(kSigmaToU90 * one.before) + " -> " +
              digits_text(kSigmaToU90 * one.after) + " " + output.unit + ")"};
}

SoftBase described_without(const Problem& problem, const Extension& extension, std::size_t output,
                           std::size_t index, bool only) {
  return only ? extension.described(output, index) : SoftBase(problem.base_columns);
}

// index: the finding that is to go if the comparison is bad. only: compared with the
// others in, else with none.
std::optional<Harm> harm_of(const Problem& problem, const std::vector<Cause>& causes,
                            const Extension& extension, std::size_t index, bool only) {
  std::optional<Harm> worst;
  for (std::size_t o = 0; o < problem.outputs.size(); ++o) {
    const auto& output = problem.outputs[o];
    const HeldOutRatio one =
        held_out_ratio(problem, output, described_without(problem, extension, o, index, only),
                       extension.described(o));
    if (!one.is_worse() || (worst && one.ratio() <= worst->ratio)) continue;
    worst = harm_to(output, causes[extension.named()[index].cause], index, one);
    worst->output = o;
  }
  return worst;
}

// The same of the motors behind the coordinates, each with what is said of it: errors of
// coordinates that are alike may cancel in a motor.
std::optional<Harm> harm_of_motors(const CoordinateFrame& frame, const Problem& problem,
                                   const std::vector<Cause>& causes, const Extension& extension,
                                   std::size_t index, bool only) {
  const Eigen::MatrixXd before = only ? judged_motors_as_served(frame, problem, extension, index)
                                      : judged_motors_by_baseline(frame, problem);
  const Eigen::MatrixXd after = judged_motors_as_served(frame, problem, extension);
  std::optional<Harm> worst;
  for (Eigen::Index m = 0; m < after.cols(); ++m) {
    const HeldOutRatio one = held_out_ratio(before.col(m), after.col(m));
    if (!one.is_worse() || (worst && one.ratio() <= worst->ratio)) continue;
    worst = harm_to(frame.motors[static_cast<std::size_t>(m)],
                    causes[extension.named()[index].cause], index, one);
    worst->motor = static_cast<std::size_t>(m);
  }
  return worst;
}

// An error of the robot enters the models that serve, one for each motor. An instrument's corrects
// a coordinate, and with it every motor.
bool may_be_of_some_motors(const Cause& cause) {
  return cause.applies_to == effects::AppliesTo::robot;
}

// Is a finding worth having for a motor other than this one, beyond the interval?
bool helps_another_motor(const CoordinateFrame& frame, const Problem& problem,
                         const Extension& extension, const Harm& harm) {
  const Eigen::MatrixXd before = judged_motors_as_served(frame, problem, extension, harm.index),
                        after = judged_motors_as_served(frame, problem, extension);
  for (Eigen::Index m = 0; m < after.cols(); ++m)
    if (static_cast<std::size_t>(m) != *harm.motor &&
        held_out_ratio(before.col(m), after.col(m)).ratio_ci90.high < 1)
      return true;
  return false;
}

// Is a finding worth having for an output other than this one, beyond the interval, and is there
// enough of it without this one to have a name?
bool helps_another(const Problem& problem, const Extension& extension, std::size_t index,
                   std::size_t output) {
  const Ground without = extension.ground(index, extension.shapes());
  if (extension.gain_where_it_acts(index, without, output).gain < kExplainedByOthers) return false;
  for (std::size_t o = 0; o < problem.outputs.size(); ++o) {
    if (o == output || extension.named()[index].share[o] == 0) continue;
    const HeldOutRatio one = held_out_ratio(problem, problem.outputs[o],
                                            extension.described(o, index), extension.described(o));
    if (one.ratio_ci90.high < 1) return true;
  }
  return false;
}

// The output that a harmful finding is left out of. Of a motor: the coordinate behind it that the
// finding describes worst. Nothing: the finding is worth nothing elsewhere.
std::optional<std::size_t> left_out_of(const Problem& problem, const Extension& extension,
                                       const Harm& harm) {
  const auto& share = extension.named()[harm.index].share;
  std::optional<std::size_t> where = harm.output;
  double most = 1;
  for (std::size_t o = 0; !harm.output && o < problem.outputs.size(); ++o) {
    if (share[o] == 0) continue;
    const double ratio = held_out_ratio(problem, problem.outputs[o],
                                        extension.described(o, harm.index), extension.described(o))
                             .ratio();
    if (ratio > most) most = ratio, where = o;
  }
  if (!where || share[*where] == 0 || !helps_another(problem, extension, harm.index, *where))
    return std::nullopt;
  return where;
}

}  // namespace

std::vector<Harmful> withdraw_what_harms(const Problem& problem, const std::vector<Cause>& causes,
                                         const std::optional<CoordinateFrame>& frame,
                                         Extension& extension, std::vector<std::string>& said) {
  std::vector<Harmful> harmful;
  while (problem.judge.size() >= kFewestJudges && !extension.named().empty()) {
    std::optional<Harm> worst;
    const auto take = [&](std::optional<Harm> harm) {
      if (harm && (!worst || harm->ratio > worst->ratio)) worst = std::move(harm);
    };
    const auto look = [&](std::size_t index, bool only) {
      take(harm_of(problem, causes, extension, index, only));
      if (frame) take(harm_of_motors(*frame, problem, causes, extension, index, only));
    };
    for (std::size_t i = 0; i < extension.named().size(); ++i) look(i, true);
    const bool alone = worst.has_value();
    if (!worst)  // no one of them, but all together: the weakest goes
      look(static_cast<std::size_t>(
               std::ranges::min_element(extension.named(), {}, &Named::evidence) -
               extension.named().begin()),
           false);
    if (!worst) break;
    // A cause need not act on every output: where it helps another it is left out of this one.
    if (const auto where = alone ? left_out_of(problem, extension, *worst) : std::nullopt) {
      said.push_back(worst->sentence + "; it is left out " +
                     (worst->output ? "there" : "of " + problem.outputs[*where].channel.symbol));
      extension.silence(worst->index, *where);
      continue;
    }
    if (alone && worst->motor &&
        may_be_of_some_motors(causes[extension.named()[worst->index].cause]) &&
        helps_another_motor(*frame, problem, extension, *worst)) {
      said.push_back(worst->sentence + "; it is left out there");
      extension.leave_out_of(worst->index, frame->motors[*worst->motor].channel.symbol);
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
    const double noise = std::pow(extension.between_neighbours(o), 2);
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
