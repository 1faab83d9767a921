#include "server/compensation/target.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <utility>

#include "server/compensation/basis_values.h"
#include "server/compensation/dot.h"
#include "server/compensation/geometry_law.h"
#include "server/compensation/target_variance.h"
#include "server/core/reasons.h"

namespace driftwise::compensation {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

double excess(const Snapshot::Input& input, double value) {
  return excess_of(input.min, input.max, value);
}

// Outside the domain nothing measured says how wrong the model is. By convention the uncertainty
// grows with the square of the distance from the domain's centre: the factor is (1 + d)^2, d the
// largest excess over all inputs in half widths: 1 at the edge, 4 at twice the range.
double extrapolation_factor(double largest_excess) {
  return (1.0 + largest_excess) * (1.0 + largest_excess);
}

void refuse(Target& target, Refusal refusal) {
  target.refusal = refusal;
  target.q_mm.fill(kNan);
  target.u_nm.fill(kNan);
}

// The fast inputs stand first. Sets the outside bits, and returns the largest excess of all inputs
// but the motors, at the pose and at the datum's zero: a target is the difference of the model
// between the two, and no better known than its worse end.
double look_at_domain(const Snapshot& snapshot, const TargetRequest& request, Target& target) {
  double largest = std::max(snapshot.slow_excess, snapshot.zero_excess);
  target.outside = snapshot.outside;
  for (std::size_t i = 0; i < snapshot.inputs.size() && snapshot.inputs[i].variable; ++i) {
    const double out = excess(
        snapshot.inputs[i], request.value[static_cast<std::size_t>(*snapshot.inputs[i].variable)]);
    if (out > 0) target.outside |= std::uint64_t{1} << i;
    largest = std::max(largest, out);
  }
  return largest;
}

// Largest excess of the motor coordinates over the ranges that they were calibrated in; sets bits
// and flag.
double look_at_motors(const Snapshot& snapshot, Target& target) {
  double largest = 0;
  for (std::size_t i = 0; i < snapshot.inputs.size(); ++i) {
    const auto& input = snapshot.inputs[i];
    const double out = input.output ? excess(input, target.q_mm[*input.output]) : 0;
    if (!(out > 0)) continue;
    target.outside |= std::uint64_t{1} << i;
    target.flags |= kOutsideDomain;
    largest = std::max(largest, out);
  }
  return largest;
}

// What cannot be computed at all.
Refusal look_at_request(const Snapshot& snapshot, const TargetRequest& request, Target& target) {
  if (snapshot.outputs.empty()) return Refusal::no_model;
  if (!snapshot.changed_parts.empty()) return Refusal::configuration_changed;
  Refusal refusal = Refusal::none;
  for (std::size_t i = 0; i < snapshot.inputs.size() && snapshot.inputs[i].variable; ++i) {
    const Variable variable = *snapshot.inputs[i].variable;
    const bool given = (request.given & bit(variable)) != 0;
    if (given && std::isfinite(request.value[static_cast<std::size_t>(variable)])) continue;
    if (refusal == Refusal::none)
      refusal = given ? Refusal::not_finite : Refusal::missing_coordinate;
    target.missing |= std::uint64_t{1} << i;
  }
  return refusal;
}

void set_flags(const Snapshot& snapshot, const TargetRequest& request, Target& target) {
  target.stale = snapshot.stale;
  target.missing = snapshot.missing;
  if (target.outside) target.flags |= kOutsideDomain;
  if (snapshot.zero_outside) target.flags |= kZeroOutsideDomain;
  if (target.stale) target.flags |= kStaleTemperature;
  if (target.missing) target.flags |= kMissingTemperature;
  if (!snapshot.anchored) target.flags |= kUnanchoredDatum;
  if (request.now > snapshot.valid_until) target.flags |= kExpiredConditions;
  target.unlimited = snapshot.unlimited;
  if (target.unlimited) target.flags |= kUnknownLimits;
  if (snapshot.configuration_changed) target.flags |= kConfigurationChanged;
  if (snapshot.unjudged) target.flags |= kUnjudgedModel;
  if (snapshot.doubtful) target.flags |= kDoubtfulModel;
  target.ignored = request.given & ~snapshot.needed;
  if (target.ignored) target.flags |= kIgnoredCoordinate;
}

// Motor coordinates of geometry and terms together; law: what the geometry says of them. found:
// empty, or the motor coordinates of an earlier answer.
Refusal find_motors(const Snapshot& snapshot, const TargetRequest& request, PoseTerms& terms,
                    bool with_uncertainty, std::span<const double> found, LawAnswer& law,
                    Target& target) {
  if (snapshot.geometry) {
    std::vector<double> of_law(found.begin(), found.end());
    for (std::size_t i = 0; i < found.size(); ++i)
      of_law[i] -= dot(snapshot.outputs[i].coefficients_mm.data(),
                       terms.basis(snapshot, request.value).b.data(), snapshot.basis_size());
    auto answer =
        snapshot.geometry->law->motors_of(request, *snapshot.geometry, with_uncertainty, of_law);
    if (!answer) {
      target.why = std::make_shared<const Error>(std::move(answer.error()));
      return Refusal::no_pose;
    }
    law = std::move(*answer);
  }
  const double* const b = terms.basis(snapshot, request.value).b.data();
  for (std::size_t i = 0; i < target.outputs; ++i) {
    double q_mm = dot(snapshot.outputs[i].coefficients_mm.data(), b, snapshot.basis_size());
    if (snapshot.geometry) q_mm += law.motors[static_cast<Eigen::Index>(i)];
    target.q_mm[i] = q_mm;
    if (!std::isfinite(q_mm)) return Refusal::outside_domain;
  }
  return Refusal::none;
}

// Soft limits are compared with the coordinate as computed. It is never clamped.
void hold_to_limits(const Snapshot& snapshot, const TargetRequest& request, Target& target) {
  for (std::size_t i = target.outputs; i-- > 0;) {
    const auto& output = snapshot.outputs[i];
    if (target.q_mm[i] >= output.min_mm && target.q_mm[i] <= output.max_mm) continue;
    target.unreachable |= 1u << i;
    target.unreachable_mm = target.q_mm[i];
  }
  if (target.unreachable == 0) return;
  target.flags |= kOutsideLimits;
  if (snapshot.refuse_outside_limits && !request.show_unreachable)
    refuse(target, Refusal::outside_limits);
}

// "q1+q3": one word, so that it can stand in a reason.
void append_axis_names(std::string& out, const Snapshot& snapshot, std::uint32_t bits) {
  bool first = true;
  for (std::size_t i = 0; i < snapshot.outputs.size(); ++i) {
    if ((bits >> i & 1) == 0) continue;
    if (!std::exchange(first, false)) out += '+';
    out += snapshot.outputs[i].channel.symbol;
  }
}
std::string axis_names(const Snapshot& snapshot, std::uint32_t bits) {
  std::string out;
  append_axis_names(out, snapshot, bits);
  return out;
}

void append_variable_names(std::string& out, std::uint32_t bits, char between) {
  bool first = true;
  for (std::size_t i = 0; i < kVariables; ++i) {
    if ((bits >> i & 1) == 0) continue;
    if (!std::exchange(first, false)) out += between;
    out += name_of(static_cast<Variable>(i));
  }
}

std::string digits_of(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.7g", value);
  return text;
}

Error beyond_limits(const Snapshot& snapshot, const Target& target) {
  const auto first = static_cast<std::size_t>(std::countr_zero(target.unreachable));
  const std::string axes = axis_names(snapshot, target.unreachable);
  if (first >= snapshot.outputs.size())
    return {ErrorCode::out_of_range, reasons::kOutsideLimits, "beyond the soft limits"};
  const auto& output = snapshot.outputs[first];
  return {ErrorCode::out_of_range, "OUTSIDE_LIMITS(" + axes + ")",
          output.channel.name() + " = " + digits_of(target.unreachable_mm) +
              " lies beyond its soft limits " + digits_of(output.min_mm) + " .. " +
              digits_of(output.max_mm) + " " + output.channel.unit +
              ": the pose cannot be reached; ask for one within the travel"};
}

void append_names(std::string& out, const Snapshot& snapshot, std::uint64_t bits, char between) {
  bool first = true;
  for (std::size_t i = 0; i < snapshot.inputs.size(); ++i) {
    if ((bits >> i & 1) == 0) continue;
    if (!std::exchange(first, false)) out += between;
    const Channel& channel = snapshot.inputs[i].channel;
    ((out += channel.symbol) += '_') += channel.unit;
  }
}
std::string names(const Snapshot& snapshot, std::uint64_t bits) {
  std::string out;
  append_names(out, snapshot, bits, ' ');
  return out;
}

}  // namespace

Target compute_target(const Snapshot& snapshot, const TargetRequest& request) noexcept {
  PoseTerms terms;
  Target target;
  compute_target(snapshot, request, terms, target);
  return target;
}

namespace {

bool is_refused_outside(const Snapshot& snapshot, const Target& target) {
  return snapshot.refuse_outside_domain && (target.outside | snapshot.zero_outside) != 0;
}

// Flags and refusals of a request that need no motor coordinates.
Refusal judge_request(const Snapshot& snapshot, const TargetRequest& request, Target& target,
                      double& largest_excess) {
  target.outputs = snapshot.outputs.size();
  target.valid_until = snapshot.valid_until;
  if (const Refusal refusal = look_at_request(snapshot, request, target); refusal != Refusal::none)
    return refusal;
  largest_excess = look_at_domain(snapshot, request, target);
  set_flags(snapshot, request, target);
  if (is_refused_outside(snapshot, target)) return Refusal::outside_domain;
  if (snapshot.refuse_stale &&
      (target.flags & (kStaleTemperature | kMissingTemperature | kExpiredConditions)))
    return Refusal::stale;
  return Refusal::none;
}

}  // namespace

JudgedMotors judge_motors(const Snapshot& snapshot, const TargetRequest& request,
                          std::span<const double> q_mm) noexcept {
  JudgedMotors judged;
  Target& target = judged.target;
  double largest_excess = 0;
  Refusal refusal = judge_request(snapshot, request, target, largest_excess);
  if (refusal == Refusal::none) {
    target.u_nm.fill(kNan);
    std::ranges::copy(q_mm, target.q_mm.begin());
    largest_excess = std::max(largest_excess, look_at_motors(snapshot, target));
    judged.factor = extrapolation_factor(largest_excess);
    if (is_refused_outside(snapshot, target)) refusal = Refusal::outside_domain;
  }
  refusal == Refusal::none ? hold_to_limits(snapshot, request, target) : refuse(target, refusal);
  return judged;
}

bool needs_search(const Snapshot& snapshot, const TargetRequest& request) noexcept {
  Target target;
  double largest_excess = 0;
  return snapshot.geometry &&
         judge_request(snapshot, request, target, largest_excess) == Refusal::none &&
         snapshot.geometry->law->needs_search(request, *snapshot.geometry);
}

void compute_target(const Snapshot& snapshot, const TargetRequest& request, PoseTerms& terms,
                    Target& target) noexcept {
  double largest_excess = 0;
  if (const Refusal refusal = judge_request(snapshot, request, target, largest_excess);
      refusal != Refusal::none)
    return refuse(target, refusal);
  LawAnswer law;
  const Refusal lost =
      find_motors(snapshot, request, terms, request.with_uncertainty, {}, law, target);
  if (lost != Refusal::none) return refuse(target, lost);
  largest_excess = std::max(largest_excess, look_at_motors(snapshot, target));
  if (is_refused_outside(snapshot, target)) return refuse(target, Refusal::outside_domain);
  const bool with_uncertainty = request.with_uncertainty && !snapshot.unjudged;
  const Basis& basis = terms.basis(snapshot, request.value);
  const double factor = extrapolation_factor(largest_excess);
  for (std::size_t i = 0; i < target.outputs; ++i) {
    const auto& output = snapshot.outputs[i];
    target.u_nm[i] = kNan;
    if (!with_uncertainty) continue;
    const Variance of_terms = whole_variance(snapshot, output, basis, terms);
    if (!of_terms.known) {
      target.why = std::make_shared<const Error>(lost_digits(snapshot, output, of_terms.form_nm2));
      return refuse(target, Refusal::no_pose);
    }
    double nm2 = of_terms.nm2;
    if (snapshot.geometry)
      for (const auto& line : output.lines) nm2 += systematic_nm2(snapshot, law, i, line, basis);
    target.u_nm[i] = std::sqrt(std::max(0.0, nm2) + share_nm2(law.fit, i) +
                               share_nm2(law.residual, i) + share_nm2(law.temperatures, i)) *
                     factor;
    if (!std::isfinite(target.u_nm[i])) return refuse(target, Refusal::outside_domain);
  }
  hold_to_limits(snapshot, request, target);
}

namespace {

// A request as far as the errors of its target are told from it.
struct Answered {
  double factor = 1;  // of extrapolation
  LawAnswer law;      // of a geometry
};

// Nothing: the request has no answer.
std::optional<Answered> answered(const Snapshot& snapshot, const TargetRequest& request,
                                 std::span<const double> found, PoseTerms& terms) {
  Target target;
  target.outputs = snapshot.outputs.size();
  if (look_at_request(snapshot, request, target) != Refusal::none) return std::nullopt;
  const double of_request = look_at_domain(snapshot, request, target);
  Answered result;
  if (find_motors(snapshot, request, terms, true, found, result.law, target) != Refusal::none)
    return std::nullopt;
  result.factor = extrapolation_factor(std::max(of_request, look_at_motors(snapshot, target)));
  return result;
}

}  // namespace

Budget compute_budget(const Snapshot& snapshot, const TargetRequest& request, std::size_t output,
                      std::span<const double> found) noexcept {
  Budget budget;
  PoseTerms terms;
  const auto about = answered(snapshot, request, found, terms);
  if (!about || output >= snapshot.outputs.size() || (snapshot.geometry && snapshot.unjudged)) {
    budget.u_nm = kNan;
    return budget;
  }
  const double factor = about->factor;
  const LawAnswer& law = about->law;
  const Basis& basis = terms.basis(snapshot, request.value);
  if (!whole_variance(snapshot, snapshot.outputs[output], basis, terms).known) {
    budget.u_nm = kNan;
    return budget;
  }
  const double* const squares = terms.squares(snapshot);
  const auto of_law = [&](UncertaintySource source) {
    return source == UncertaintySource::fit            ? share_nm2(law.fit, output)
           : source == UncertaintySource::residual     ? share_nm2(law.residual, output)
           : source == UncertaintySource::temperatures ? share_nm2(law.temperatures, output)
                                                       : 0.0;
  };
  double sum = 0;
  for (const auto& line : snapshot.outputs[output].lines) {
    const double terms_nm2 = line_variance(line, snapshot.basis_size(), basis, squares) +
                             systematic_nm2(snapshot, law, output, line, basis);
    const double nm2 = std::max(0.0, terms_nm2) + of_law(line.source);
    budget.line[budget.lines++] = {line.source, std::sqrt(nm2)};
    sum += nm2;
  }
  if (factor > 1)
    budget.line[budget.lines++] = {UncertaintySource::extrapolation,
                                   std::sqrt(sum * (factor * factor - 1))};
  budget.u_nm = std::sqrt(sum) * factor;
  return budget;
}

ErrorParts error_parts(const Snapshot& snapshot, const TargetRequest& request) {
  ErrorParts parts;
  PoseTerms terms;
  const auto about = answered(snapshot, request, {}, terms);
  if (!about) return parts;
  parts.factor = about->factor;
  const LawAnswer& law = about->law;
  const Basis& basis = terms.basis(snapshot, request.value);
  const double* const squares = terms.squares(snapshot);
  const std::size_t outputs = snapshot.outputs.size(), size = snapshot.basis_size();
  std::map<std::pair<UncertaintySource, std::uint32_t>, std::vector<double>> shared;
  for (std::size_t i = 0; i < outputs; ++i) {
    double own_nm2 = 0;
    if (const auto all = whole_variance(snapshot, snapshot.outputs[i], basis, terms); !all.known)
      own_nm2 = kNan;
    else if (snapshot.outputs[i].lines.empty())
      own_nm2 = all.nm2;
    for (const auto& line : snapshot.outputs[i].lines) {
      if (!line.variance_nm2.empty())
        own_nm2 += std::max(0.0, variance(line.variance_nm2, squares));
      for (std::size_t row = 0; (row + 1) * size <= line.roots_nm.size(); ++row) {
        const double nm = dot(line.roots_nm.data() + row * size, basis.b.data(), size);
        if (row >= line.errors.size()) {
          own_nm2 += nm * nm;
          continue;
        }
        auto& in_outputs = shared[{line.source, line.errors[row]}];
        in_outputs.resize(outputs);
        in_outputs[i] += nm;
      }
    }
    for (Eigen::Index e = 0; e < law.systematic.cols(); ++e) {
      const auto& error = snapshot.geometry->errors[static_cast<std::size_t>(e)];
      auto& in_outputs = shared[{error.source, error.number}];
      in_outputs.resize(outputs);
      in_outputs[i] += kNmPerMm * law.systematic(static_cast<Eigen::Index>(i), e);
    }
    own_nm2 += share_nm2(law.fit, i) + share_nm2(law.residual, i) + share_nm2(law.temperatures, i);
    parts.own_nm2.push_back(own_nm2);
  }
  for (auto& [error, in_outputs] : shared) parts.shared_nm.push_back(std::move(in_outputs));
  return parts;
}

void append_flags(std::string& out, const Snapshot& snapshot, const Target& target, char between) {
  const std::size_t start = out.size();
  const auto add_named = [&](std::string_view name, const auto& append_whom) {
    if (out.size() > start) out += ',';
    out += name;
    out += '(';
    const std::size_t named = out.size();
    append_whom();
    if (out.size() == named)
      out.pop_back();
    else
      out += ')';
  };
  const auto add = [&](std::string_view name, std::uint64_t bits) {
    add_named(name, [&] { append_names(out, snapshot, bits, between); });
  };
  const auto add_axes = [&](std::string_view name, std::uint32_t bits) {
    add_named(name, [&] { append_axis_names(out, snapshot, bits); });
  };
  if (target.flags & kOutsideDomain) add(reasons::kOutsideDomain.view(), target.outside);
  if (target.flags & kStaleTemperature) add("STALE_TEMPERATURE", target.stale);
  if (target.flags & kMissingTemperature) add("MISSING_TEMPERATURE", target.missing);
  if (target.flags & kExpiredConditions) add("EXPIRED_CONDITIONS", 0);
  if (target.flags & kUnanchoredDatum) add("UNANCHORED_DATUM", 0);
  if (target.flags & kOutsideLimits) add_axes(reasons::kOutsideLimits.view(), target.unreachable);
  if (target.flags & kUnknownLimits) add_axes("UNKNOWN_LIMITS", target.unlimited);
  if (target.flags & kIgnoredCoordinate)
    add_named("IGNORED_COORDINATE", [&] { append_variable_names(out, target.ignored, between); });
  if (target.flags & kConfigurationChanged) add(reasons::kConfigurationChanged.view(), 0);
  if (target.flags & kUnjudgedModel) add("UNJUDGED_MODEL", 0);
  if (target.flags & kZeroOutsideDomain) add("ZERO_OUTSIDE_DOMAIN", snapshot.zero_outside);
  if (target.flags & kDoubtfulModel) add("DOUBTFUL_MODEL", 0);
}

std::string describe_flags(const Snapshot& snapshot, const Target& target) {
  std::string out;
  append_flags(out, snapshot, target, ' ');
  return out;
}

Error refusal_error(const Snapshot& snapshot, const Target& target) {
  switch (target.refusal) {
    case Refusal::none:
      break;
    case Refusal::no_model:
      if (snapshot.unserved) return *snapshot.unserved;
      return {ErrorCode::failed_precondition, reasons::kNoModel,
              "no model serves: fit one and promote it, or ask the serving plan for a joint target "
              "(driftwise plan target; text line: JOINT)"};
    case Refusal::missing_coordinate:
      return {ErrorCode::invalid_argument, reasons::kMissingCoordinate,
              "the request lacks " + names(snapshot, target.missing) +
                  ", which the model needs: state it, 0 included"};
    case Refusal::not_finite:
      return {ErrorCode::invalid_argument, reasons::kNotFinite,
              "found no finite number for " + names(snapshot, target.missing) +
                  ": state it in the unit of its name"};
    case Refusal::outside_domain:
      if (target.outside == 0 && snapshot.refuse_outside_domain && snapshot.zero_outside != 0)
        return {ErrorCode::out_of_range, reasons::kOutsideDomain,
                "the zero of the present datum was taken with " +
                    names(snapshot, snapshot.zero_outside) +
                    " outside what the model was fitted on, and this cell refuses such targets "
                    "([serving] refuse_outside_domain): take the zero again within it"};
      return {ErrorCode::out_of_range, reasons::kOutsideDomain,
              names(snapshot, target.outside) +
                  (snapshot.refuse_outside_domain
                       ? " outside what the model was fitted on, and this cell refuses such "
                         "targets ([serving] refuse_outside_domain)"
                       : " so far outside what the model was fitted on that it gives no number: "
                         "ask within its domain")};
    case Refusal::configuration_changed:
      return {
          ErrorCode::failed_precondition, reasons::kConfigurationChanged,
          "the cell file has changed in what model " + std::to_string(snapshot.model.value) +
              " uses, and nobody has accepted it: " + snapshot.changed_parts +
              ". Look at it and accept it (driftwise configuration accept), or put the file back"};
    case Refusal::stale: {
      const std::string who = names(snapshot, target.stale | target.missing);
      return {
          ErrorCode::failed_precondition, reasons::kStale,
          (who.empty() ? std::string("the conditions were not looked at in time")
                       : who + " too old or never read") +
              ", and this cell refuses such targets ([serving] refuse_stale): look at the scanner"};
    }
    case Refusal::outside_limits:
      return beyond_limits(snapshot, target);
    case Refusal::no_pose:
      if (target.why) return *target.why;
      break;
  }
  return {ErrorCode::internal, reasons::kNotRefused,
          "asked for the refusal of a target that was not refused"};
}

}  // namespace driftwise::compensation
