#include "server/application/diagnoses/taken_side.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/core/units.h"
#include "server/diagnosis/separating/hypothesis.h"
#include "server/formats/formula/formula.h"

namespace driftwise::application {
namespace {

const diagnosis::Finding& finding_in(const diagnosis::Diagnosis& found, int number) {
  return found.findings[static_cast<std::size_t>(number - 1)];
}

// Standard errors of a jump's size in each output, mm; 0: the output does not show it.
Eigen::VectorXd errors_of_jump(const diagnosis::Finding& finding, const InstrumentClaim& claim) {
  Eigen::VectorXd errors = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(claim.outputs.size()));
  for (const auto& output : finding.outputs) {
    const auto at = std::ranges::find(claim.outputs, output.output, &Channel::symbol);
    if (at == claim.outputs.end() || output.coefficients.empty()) continue;
    const double mm_per_unit = mm_from_nm(summary_unit(at->unit).factor);
    const double error =
        std::abs(output.coefficients.front()) / std::sqrt(std::max(output.gain_2lnl, 1.0));
    errors[at - claim.outputs.begin()] = mm_per_unit * error;
  }
  return errors;
}

// The cause's own terms and amplitudes, beside the baseline and the other findings.
Result<diagnosis::Finding> rival_of(const diagnosis::Diagnosis& found, int number,
                                    const std::string& name, const Dataset& data) {
  const auto& finding = finding_in(found, number);
  DRIFTWISE_TRY(const auto formula, formats::Formula::parse(found.baseline_formula));
  DRIFTWISE_TRY(const auto baseline, formula.expand(data));
  DRIFTWISE_TRY(const auto open, diagnosis::open_hypotheses(data, baseline, found,
                                                            static_cast<std::size_t>(number - 1)));
  const auto rival = std::ranges::find(open, name, &diagnosis::Hypothesis::name);
  if (rival == open.end() || rival->cells.empty())
    return fail(ErrorCode::failed_precondition, reasons::kNoSuchFinding,
                fmt::format("finding {} ({}) was not told apart from {}, but these data give that "
                            "cause no size: measure what separates them",
                            number, name_of(finding), name));
  diagnosis::Finding taken = finding;
  const auto space = name.find(' ');
  taken.cause = name.substr(0, space);
  taken.subject = space == std::string::npos ? "" : name.substr(space + 1);
  taken.applies_to = taken.cause == "step_change"   ? effects::AppliesTo::dataset
                     : side_of(name) == Side::robot ? effects::AppliesTo::robot
                                                    : effects::AppliesTo::correction;
  taken.indistinguishable_from.clear();
  taken.parameters.clear();
  const auto& best = rival->cells.front();
  taken.terms = best.terms;
  taken.outputs.clear();
  for (std::size_t o = 0; o < baseline.outputs.size(); ++o) {
    diagnosis::FindingOutput output;
    output.output = baseline.outputs[o];
    const auto* column = data.find(output.output);
    if (column == nullptr || best.coefficients.cols() <= static_cast<Eigen::Index>(o)) continue;
    const auto unit = summary_unit(column->channel.unit);
    output.unit = unit.unit;
    for (const auto& old : finding.outputs)
      if (old.output == output.output) output.gain_2lnl = old.gain_2lnl;
    for (Eigen::Index k = 0; k < best.coefficients.rows(); ++k)
      output.coefficients.push_back(best.coefficients(k, static_cast<Eigen::Index>(o)) /
                                    unit.factor);
    taken.outputs.push_back(std::move(output));
  }
  if (const auto* jump = taken.terms.size() == 1 && taken.terms[0].factors.size() == 1
                             ? std::get_if<effects::Call>(&taken.terms[0].factors[0])
                             : nullptr;
      jump != nullptr && jump->effect == "step" && !jump->parameters.empty())
    taken.parameters.push_back({"time_s", jump->parameters.front().value, {}, {}});
  taken.sentence = fmt::format("{}, taken for {}: {}", name_of(finding), name, finding.sentence);
  return taken;
}

}  // namespace

std::optional<Side> side_of_jump(const diagnosis::Finding& finding, const InstrumentClaim& claim) {
  const Eigen::VectorXd errors = errors_of_jump(finding, claim);
  if (claim.seen_mm.cols() != 1 || (errors.array() > 0).count() < 2) return std::nullopt;
  const double floor = errors.maxCoeff() / 4;  // of an output that says next to nothing
  const Eigen::ArrayXd weight = 1 / errors.array().max(floor);
  const Eigen::VectorXd seen = (claim.seen_mm.col(0).array() * weight).matrix();
  double of_axis = HUGE_VAL, of_motor = HUGE_VAL;
  for (Eigen::Index a = 0; a < claim.slopes.cols(); ++a) {
    const Eigen::VectorXd slope = (claim.slopes.col(a).array() * weight).matrix();
    if (!(slope.squaredNorm() > 0)) continue;
    of_axis =
        std::min(of_axis, (seen - slope * (slope.dot(seen) / slope.squaredNorm())).squaredNorm());
  }
  for (Eigen::Index o = 0; o < seen.size(); ++o)
    of_motor = std::min(of_motor, seen.squaredNorm() - seen[o] * seen[o]);
  if (of_motor > of_axis + kTold2lnl) return Side::instrument;
  if (of_axis > of_motor + kTold2lnl) return Side::robot;
  return std::nullopt;
}

Result<diagnosis::Finding> taken_as(const diagnosis::Diagnosis& found, int number,
                                    const std::string& taken_as, const Dataset& data) {
  const auto& finding = finding_in(found, number);
  const std::string own = name_of(finding);
  if (taken_as == own || taken_as == to_string(side_of(own))) return finding;
  for (const auto& rival : finding.indistinguishable_from)
    if (taken_as == rival || taken_as == to_string(side_of(rival)))
      return rival_of(found, number, rival, data);
  if (finding.cause == "step_change" && taken_as == to_string(Side::robot)) {
    diagnosis::Finding slip = finding;
    slip.applies_to = effects::AppliesTo::robot;
    return slip;
  }
  return fail(
      ErrorCode::failed_precondition, reasons::kNoSuchFinding,
      fmt::format("finding {} ({}) cannot be taken as '{}': expected robot, instrument{}{}", number,
                  own, taken_as, finding.indistinguishable_from.empty() ? "" : " or one of ",
                  fmt::join(finding.indistinguishable_from, ", ")));
}

Error side_unknown(DiagnosisId id, const diagnosis::Diagnosis& found, int number) {
  const auto& finding = finding_in(found, number);
  std::string measure = "measure from another starting state, so that they differ";
  if (finding.cause == "step_change")
    measure = "zero again: targets count from the latest zero, and the jump drops out";
  else if (found.separating_experiment && !found.separating_experiment->trajectory_csv.empty())
    measure = fmt::format("run the measurement that separates them, which diagnosis {} holds ({})",
                          id.value, found.separating_experiment->why);
  const std::string other =
      finding.cause == "step_change"
          ? "a motor that slipped, whose new place the target would have to follow"
          : fmt::format("{}", fmt::join(rivals_across(finding), ", "));
  return {
      ErrorCode::failed_precondition, reasons::kIndistinguishable,
      fmt::format("finding {0} ({1}) is an effect of the {2}, or these data show {3}: they do not "
                  "tell. A target follows the robot and no instrument, and the wrong one moves it "
                  "by twice the effect. Either {4}; or, where you know that it is of the {2}, "
                  "accept it by its number (--finding {0})",
                  number, name_of(finding), to_string(side_of(name_of(finding))), other, measure)};
}

}  // namespace driftwise::application
