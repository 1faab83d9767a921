#include "tests/hidden_effects/shapes/hidden_case.h"

#include <Eigen/QR>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "server/calibration/design/predict.h"
#include "server/core/units.h"
#include "server/diagnosis/diagnose.h"
#include "server/formats/formula/formula.h"

namespace driftwise::hidden {
namespace {

std::string cause_in(const std::string& rival) { return rival.substr(0, rival.find(' ')); }

bool lists(const diagnosis::Finding& finding, const std::string& cause) {
  return finding.cause == cause ||
         std::ranges::any_of(finding.indistinguishable_from,
                             [&](const std::string& rival) { return cause_in(rival) == cause; });
}

void judge_names(const HiddenData& made, const diagnosis::Diagnosis& found, Outcome& outcome) {
  std::vector<Hidden> missing = made.hidden;
  std::vector<diagnosis::Finding> others;
  outcome.subject = true;
  for (const auto& finding : found.findings) {
    outcome.named += (outcome.named.empty() ? "" : "; ") + finding.cause + " " + finding.subject;
    const auto own = std::ranges::find(missing, finding.cause, &Hidden::cause);
    if (own == missing.end()) {
      others.push_back(finding);
      continue;
    }
    outcome.subject = outcome.subject && own->subject == finding.subject;
    missing.erase(own);
  }
  outcome.exact = missing.empty() && others.empty();
  for (const auto& finding : others) {
    const auto meant =
        std::ranges::find_if(missing, [&](const Hidden& one) { return lists(finding, one.cause); });
    if (meant == missing.end())
      ++outcome.false_names;
    else
      missing.erase(meant);
  }
  outcome.exact_or_set = missing.empty() && outcome.false_names == 0;
  outcome.subject = outcome.subject && outcome.exact;
}

// Held-out U90 of the outputs together with the true effect taken off.
double oracle_u90(const HiddenData& made, const Eigen::MatrixXd& base) {
  double sum = 0;
  std::vector<Eigen::Index> learn, judge;
  for (std::size_t i = 0; i < made.data.rows; ++i)
    (made.data.set_of(i) == PointSet::calibration ? learn : judge)
        .push_back(static_cast<Eigen::Index>(i));
  const Eigen::MatrixXd x = base(learn, Eigen::all);
  const Eigen::VectorXd scale = x.colwise().norm();
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(x * scale.cwiseInverse().asDiagonal());
  for (Eigen::Index o = 0; o < made.effect_nm.cols(); ++o) {
    const auto& values = made.data.columns[static_cast<std::size_t>(o)].values;
    const Eigen::VectorXd y =
        Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size())) *
            kNmPerMm -
        made.effect_nm.col(o);
    const Eigen::VectorXd b = qr.solve(y(learn)).cwiseQuotient(scale);
    const Eigen::VectorXd left = y(judge) - base(judge, Eigen::all) * b;
    sum += (left.array() - left.mean()).square().mean();
  }
  return kSigmaToU90 * std::sqrt(sum);
}

void judge_gain(const HiddenData& made, const diagnosis::Diagnosis& found,
                const calibration::Candidates& baseline, Outcome& outcome) {
  std::vector<effects::Term> terms = {effects::Term{}};
  terms.insert(terms.end(), baseline.terms.begin(), baseline.terms.end());
  double before = 0, after = 0;
  for (const auto& output : found.outputs) {
    before += std::pow(output.u90_validation_before.value_or(0), 2);
    after += std::pow(output.u90_validation_after.value_or(0), 2);
  }
  outcome.gain = std::sqrt(before) - std::sqrt(after);
  outcome.gain_of_truth =
      std::sqrt(before) - oracle_u90(made, *calibration::raw_columns(made.data, terms));
}

void judge_interval(const HiddenData& made, const diagnosis::Diagnosis& found,
                    const std::optional<double>& bound_sd, Outcome& outcome) {
  const Hidden& hidden = made.hidden.front();
  for (const auto& finding : found.findings) {
    if (finding.cause != hidden.cause || hidden.parameter == 0 || hidden.cause == "backlash")
      continue;
    for (const auto& parameter : finding.parameters) {
      if (!parameter.ci90 || parameter.curve.empty()) continue;
      outcome.covers =
          parameter.ci90->low <= hidden.parameter && hidden.parameter <= parameter.ci90->high ? 1
                                                                                              : 0;
      if (bound_sd)
        outcome.width_over_bound =
            (parameter.ci90->high - parameter.ci90->low) / (2 * kSigmaToU90 * *bound_sd);
    }
  }
}

}  // namespace

Outcome judged(const World& world, const std::vector<Hidden>& hidden, std::uint64_t seed, int nulls,
               bool with_truth) {
  const HiddenData made = make(world, hidden, seed);
  diagnosis::DiagnoseOptions options;
  const auto baseline = formats::Formula::parse(made.baseline)->expand(made.data);
  if (!baseline) throw std::runtime_error(baseline.error().message);
  options.baseline = *baseline;
  options.nulls = nulls;
  options.seed = seed + 1;
  const auto begin = std::chrono::steady_clock::now();
  const auto found = diagnosis::diagnose(made.data, options);
  if (!found) throw std::runtime_error(found.error().message);
  Outcome outcome;
  outcome.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  outcome.verdict = diagnosis::to_string(found->verdict);
  if (found->findings.empty())
    for (const auto& warning : found->warnings)
      if (warning.starts_with("next would come")) outcome.note = warning;
  judge_names(made, *found, outcome);
  judge_gain(made, *found, *baseline, outcome);
  if (with_truth && made.hidden.size() == 1 && made.effect_nm.norm() > 0 &&
      !made.hidden.front().cause.starts_with("uncatalogued")) {
    const Truth truth = truth_of(made);
    outcome.identifiable = truth.identifiable;
    judge_interval(made, *found, truth.bound_sd, outcome);
  }
  return outcome;
}

}  // namespace driftwise::hidden
