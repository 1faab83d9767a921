#include "server/plans/joint_target.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "server/compensation/basis_values.h"
#include "server/compensation/dot.h"

namespace driftwise::plans {
namespace {

using compensation::Refusal;
using compensation::Snapshot;
using compensation::Target;
using compensation::TargetRequest;
using compensation::Variable;

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kForce = static_cast<std::size_t>(Variable::force);
constexpr std::size_t kZ = static_cast<std::size_t>(Variable::z);

double squared(double value) { return value * value; }

void refuse(JointTarget& target, Refusal refusal, std::size_t robot,
            std::uint32_t coordinates = 0) {
  target.refusal = refusal;
  target.refused_robot = robot;
  target.refused = coordinates;
  target.q_mm.fill(kNotANumber);
  target.u_nm.fill(kNotANumber);
}

std::size_t owners_of(const JointSnapshot& snapshot, std::uint32_t mark) {
  std::size_t owners = 0;
  for (const auto& robot : snapshot.robots) owners += (robot.stated & mark) != 0 ? 1 : 0;
  return owners;
}

// The wanted pose of every robot, from what the request states with and without a robot's id.
bool resolve(const JointSnapshot& snapshot, const JointRequest& request, JointTarget& target) {
  constexpr std::size_t kShared = JointRequest::kNoRobot;
  std::uint32_t known = 0;
  for (std::size_t r = 0; r < snapshot.robots.size(); ++r) {
    const auto& robot = snapshot.robots[r];
    known |= robot.stated;
    target.ignored[r] = request.given[r] & ~robot.stated;
    for (std::size_t v = 0; v < compensation::kVariables; ++v) {
      const std::uint32_t mark = std::uint32_t{1} << v;
      if ((robot.stated & mark) == 0) continue;
      double value = kNotANumber;
      bool found = true;
      if ((request.given[r] & mark) != 0) {
        value = request.value[r][v];
      } else if (v == kZ && snapshot.z_taken_by && *snapshot.z_taken_by != r) {
        value = snapshot.z_rest_mm;
      } else if ((request.given[kShared] & mark) != 0) {
        value = request.value[kShared][v];
        if (v != kForce && !(v == kZ && snapshot.z_taken_by) && owners_of(snapshot, mark) > 1) {
          refuse(target, Refusal::missing_coordinate, r, mark);
          target.ambiguous = true;
          return false;
        }
      } else {
        found = false;
      }
      if (!found || !std::isfinite(value)) {
        refuse(target, found ? Refusal::not_finite : Refusal::missing_coordinate, r, mark);
        return false;
      }
      target.robot[r].pose[v] = value;
    }
  }
  target.ignored[kShared] = request.given[kShared] & ~known;
  return true;
}

TargetRequest asked_at(const Values& pose, const JointRequest& request) {
  TargetRequest asked;
  asked.value = pose;
  asked.with_uncertainty = request.with_uncertainty;
  asked.show_unreachable = true;  // limits are those of the whole, looked at last
  asked.now = request.now;
  return asked;
}

using Variances = std::array<double, compensation::kVariables>;

// Of one model at one pose: its target, and its outputs' slopes by the coordinates that something
// uncertain was added to.
struct ModelAnswer {
  Target target;
  std::array<std::array<double, compensation::kMaxOutputs>, compensation::kVariables> slope;
};

void slopes_of(const Snapshot& model, const compensation::PoseTerms& terms, Variable by,
               double* out) {
  compensation::Basis slope;
  terms.slope(model, by, slope);
  for (std::size_t i = 0; i < model.outputs.size(); ++i)
    out[i] = compensation::dot(model.outputs[i].coefficients_mm.data(), slope.b.data(),
                               model.basis_size());
}

void answer_model(const Snapshot& model, TargetRequest& asked, const Variances& variance,
                  compensation::PoseTerms& terms, ModelAnswer& answer) {
  asked.given = model.needed;
  compensation::compute_target(model, asked, terms, answer.target);
  if (answer.target.refusal != Refusal::none) return;
  for (std::size_t v = 0; v < compensation::kVariables; ++v)
    if (!(variance[v] <= 0))
      slopes_of(model, terms, static_cast<Variable>(v), answer.slope[v].data());
}

// Motion as every step predicts it, added to the poses; a further pass replaces what the one before
// added. variance: of what was added, nm^2, by robot and coordinate.
bool take_steps(const JointSnapshot& snapshot, const JointRequest& request, JointTarget& target,
                std::array<Variances, kMostRobots>& variance, compensation::PoseTerms& terms) {
  for (std::size_t pass = 0; pass < snapshot.passes; ++pass) {
    const bool first = pass == 0, last = pass + 1 == snapshot.passes;
    std::size_t next = 0;  // term
    for (std::size_t s = 0; s < snapshot.steps.size(); ++s) {
      const auto& step = snapshot.steps[s];
      TargetRequest asked = asked_at(target.robot[step.from].pose, request);
      asked.given = step.predicts.needed;
      asked.with_uncertainty = request.with_uncertainty && last;
      terms.clear();
      Target predicted;
      compensation::compute_target(step.predicts, asked, terms, predicted);
      if (predicted.refusal != Refusal::none) {
        refuse(target, predicted.refusal, step.from);
        target.why = predicted.why;
        return false;
      }
      // Variance of what earlier steps added to this pose, through this step's slopes.
      std::array<double, compensation::kMaxOutputs> from_before{};
      if (asked.with_uncertainty)
        for (std::size_t v = 0; v < compensation::kVariables; ++v) {
          if (variance[step.from][v] <= 0) continue;
          std::array<double, compensation::kMaxOutputs> slope;
          slopes_of(step.predicts, terms, static_cast<Variable>(v), slope.data());
          for (std::size_t i = 0; i < predicted.outputs; ++i)
            from_before[i] += squared(slope[i]) * variance[step.from][v];
        }
      target.step_flags[s] = predicted.flags & ~std::uint32_t{compensation::kUnknownLimits};
      target.step_outside[s] = predicted.outside;
      target.step_stale[s] = predicted.stale;
      target.step_missing[s] = predicted.missing;
      target.valid_until = std::min(target.valid_until, predicted.valid_until);
      for (std::size_t i = 0; i < predicted.outputs && next < kMostTerms; ++i) {
        auto& term = target.term[next++];
        const double before = first ? 0 : term.value;
        term = {static_cast<std::uint8_t>(s), static_cast<std::uint8_t>(i),
                (step.added >> i & 1) != 0, predicted.q_mm[i], predicted.u_nm[i]};
        if (asked.with_uncertainty) term.u = std::hypot(term.u, std::sqrt(from_before[i]));
        if (!term.added) continue;
        const auto v = static_cast<std::size_t>(step.output[i]);
        target.robot[step.to].pose[v] += term.value - before;
        if (asked.with_uncertainty) variance[step.to][v] += term.u * term.u;
      }
    }
    target.terms = next;
  }
  return true;
}

void take_flags(const Target& from, ModelFlags& model, JointTarget::Robot& into) {
  model = {from.flags, from.outside, from.stale, from.missing};
  into.flags |= from.flags & ~std::uint32_t{compensation::kOutsideLimits};
  into.unlimited = from.unlimited;
}

// The band lies where the fine model ends: beyond its domain in the band's coordinates the coarse
// one vouches. In a temperature or a force it does not.
void forgive_band(const JointSnapshot::Robot& robot, Target& fine) {
  for (std::size_t i = 0; i < robot.fine.inputs.size(); ++i)
    for (std::size_t p = 0; p < robot.band.parts; ++p)
      if (robot.fine.inputs[i].variable == robot.band.part[p].coordinate)
        fine.outside &= ~(std::uint64_t{1} << i);
  if (fine.outside == 0) fine.flags &= ~std::uint32_t{compensation::kOutsideDomain};
}

// One robot's motor coordinates with their uncertainty.
bool answer_robot(const JointSnapshot::Robot& robot, std::size_t r, const JointRequest& request,
                  const Variances& variance, JointTarget& target, compensation::PoseTerms& terms) {
  auto& out = target.robot[r];
  const std::size_t count = robot.fine.outputs.size();
  out.first = target.outputs;
  out.outputs = count;
  const double w = robot.coarse ? fine_weight(robot.band, out.pose) : 1.0;
  const double fade = robot.coarse && w < 1 ? anchor_fade(robot.band, out.pose) : 0.0;
  out.weight = w;
  out.by = !robot.coarse ? AnsweredBy::one
           : w >= 1      ? AnsweredBy::fine
           : w <= 0      ? AnsweredBy::coarse
                         : AnsweredBy::blend;
  ModelAnswer of_fine, of_coarse;
  Target &fine = of_fine.target, &coarse = of_coarse.target;
  TargetRequest asked = asked_at(out.pose, request);
  terms.clear();
  if (w > 0) answer_model(robot.fine, asked, variance, terms, of_fine);
  if (w > 0 && !robot.same_terms) terms.clear();
  if (w < 1) answer_model(*robot.coarse, asked, variance, terms, of_coarse);
  for (const Target* one : {&fine, &coarse})
    if (one->refusal != Refusal::none) {
      refuse(target, one->refusal, r);
      target.why = one->why;
      return false;
    }
  if (w > 0) {
    if (w < 1) forgive_band(robot, fine);
    take_flags(fine, out.fine, out);
    target.valid_until = std::min(target.valid_until, fine.valid_until);
  }
  if (w < 1) {
    take_flags(coarse, out.coarse, out);
    target.valid_until = std::min(target.valid_until, coarse.valid_until);
  }

  std::array<double, compensation::kMaxOutputs> shift, at_border, propagated;
  if (fade > 0) {
    const Values border = held_at_border(robot.band, out.pose);
    model_coordinates(robot.fine, border, shift.data());
    model_coordinates(*robot.coarse, border, at_border.data());
  }
  for (std::size_t i = 0; i < count; ++i) {
    shift[i] = fade > 0 ? shift[i] - at_border[i] : 0;
    propagated[i] = 0;
  }
  for (std::size_t v = 0; v < compensation::kVariables; ++v) {
    if (variance[v] <= 0) continue;
    for (std::size_t i = 0; i < count; ++i) {
      const double mixed =
          (w > 0 ? w * of_fine.slope[v][i] : 0) + (w < 1 ? (1 - w) * of_coarse.slope[v][i] : 0);
      propagated[i] += mixed * mixed * variance[v];
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    const double other = w < 1 ? coarse.q_mm[i] + fade * shift[i] : 0;
    const double q = w >= 1 ? fine.q_mm[i] : w <= 0 ? other : w * fine.q_mm[i] + (1 - w) * other;
    const double apart_nm = w > 0 && w < 1 ? std::abs(fine.q_mm[i] - other) * kNmPerMm : 0;
    out.difference_nm = std::max(out.difference_nm, apart_nm);
    target.q_mm[target.outputs] = q;
    double u2 = propagated[i];
    // Both models stand on one zero and on the same declared instruments: their errors are no
    // independent ones, and an average of them is not better than they are.
    u2 += squared((w > 0 ? w * fine.u_nm[i] : 0) + (w < 1 ? (1 - w) * coarse.u_nm[i] : 0));
    u2 += squared(w * (1 - w) * apart_nm);
    u2 += squared((1 - w) * fade * (1 - fade) * shift[i] * kNmPerMm);
    target.u_nm[target.outputs] = request.with_uncertainty ? std::sqrt(u2) : kNotANumber;
    ++target.outputs;
    if (!std::isfinite(q) || (request.with_uncertainty && !std::isfinite(u2))) {
      refuse(target, Refusal::outside_domain, r);
      return false;
    }
  }
  return true;
}

// Soft limits are compared with the coordinates as computed. They are never clamped.
void look_at_limits(const JointSnapshot& snapshot, JointTarget& target) {
  for (std::size_t r = target.robots; r-- > 0;) {
    auto& robot = target.robot[r];
    for (std::size_t i = robot.outputs; i-- > 0;) {
      const auto& output = snapshot.robots[r].fine.outputs[i];
      const double q = target.q_mm[robot.first + i];
      if (q >= output.min_mm && q <= output.max_mm) continue;
      robot.unreachable |= std::uint32_t{1} << i;
      robot.flags |= compensation::kOutsideLimits;
      target.unreachable_mm = q;
    }
  }
}

// By the rules of the cell.
Refusal refused_by_rule(const JointSnapshot& snapshot, const JointRequest& request,
                        const JointTarget& target, std::size_t& robot) {
  constexpr std::uint32_t kOld = compensation::kStaleTemperature |
                                 compensation::kMissingTemperature |
                                 compensation::kExpiredConditions;
  constexpr std::uint32_t kOutside =
      compensation::kOutsideDomain | compensation::kZeroOutsideDomain;
  const auto judged = [&](std::uint32_t flags) {
    if (snapshot.refuse_outside_domain && (flags & kOutside) != 0) return Refusal::outside_domain;
    if (snapshot.refuse_stale && (flags & kOld) != 0) return Refusal::stale;
    if (snapshot.refuse_outside_limits && !request.show_unreachable &&
        (flags & compensation::kOutsideLimits) != 0)
      return Refusal::outside_limits;
    return Refusal::none;
  };
  for (std::size_t s = 0; s < snapshot.steps.size(); ++s)
    if (const Refusal found = judged(target.step_flags[s]); found != Refusal::none) {
      robot = snapshot.steps[s].from;
      return found;
    }
  for (std::size_t r = 0; r < target.robots; ++r)
    if (const Refusal found = judged(target.robot[r].flags); found != Refusal::none) {
      robot = r;
      return found;
    }
  return Refusal::none;
}

}  // namespace

void model_coordinates(const Snapshot& snapshot, const Values& pose, double* out) noexcept {
  compensation::Basis basis;
  compensation::fill_basis(snapshot, compensation::columns_of(snapshot, pose), basis);
  for (std::size_t i = 0; i < snapshot.outputs.size(); ++i)
    out[i] = compensation::dot(snapshot.outputs[i].coefficients_mm.data(), basis.b.data(),
                               snapshot.basis_size());
}

void model_slopes(const Snapshot& model, const Values& pose, Variable by, double* out) noexcept {
  compensation::PoseTerms terms;
  terms.basis(model, pose);
  slopes_of(model, terms, by, out);
}

void robot_coordinates(const JointSnapshot::Robot& robot, const Values& pose,
                       double* out) noexcept {
  const double w = robot.coarse ? fine_weight(robot.band, pose) : 1.0;
  if (w >= 1) return model_coordinates(robot.fine, pose, out);
  const double fade = anchor_fade(robot.band, pose);
  std::array<double, compensation::kMaxOutputs> fine{}, shift{}, at_border{};
  model_coordinates(*robot.coarse, pose, out);
  if (w > 0) model_coordinates(robot.fine, pose, fine.data());
  if (fade > 0) {
    const Values border = held_at_border(robot.band, pose);
    model_coordinates(robot.fine, border, shift.data());
    model_coordinates(*robot.coarse, border, at_border.data());
  }
  for (std::size_t i = 0; i < robot.fine.outputs.size(); ++i)
    out[i] = w * fine[i] + (1 - w) * (out[i] + fade * (shift[i] - at_border[i]));
}

namespace {

void answer_all(const JointSnapshot& snapshot, const JointRequest& request, JointTarget& target) {
  target.robots = snapshot.robots.size();
  target.valid_until = snapshot.valid_until;
  if (snapshot.robots.empty()) return refuse(target, Refusal::no_model, kMostRobots);
  if (!resolve(snapshot, request, target)) return;
  std::array<Variances, kMostRobots> variance{};
  compensation::PoseTerms terms;
  if (!take_steps(snapshot, request, target, variance, terms)) return;
  for (std::size_t r = 0; r < snapshot.robots.size(); ++r)
    if (!answer_robot(snapshot.robots[r], r, request, variance[r], target, terms)) return;
  look_at_limits(snapshot, target);
  std::size_t robot = kMostRobots;
  if (const Refusal refusal = refused_by_rule(snapshot, request, target, robot);
      refusal != Refusal::none)
    refuse(target, refusal, robot);
}

}  // namespace

JointTarget compute_joint_target(const JointSnapshot& snapshot,
                                 const JointRequest& request) noexcept {
  JointTarget target;
  answer_all(snapshot, request, target);
  return target;
}

}  // namespace driftwise::plans
