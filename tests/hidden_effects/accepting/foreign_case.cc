#include "tests/hidden_effects/accepting/foreign_case.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <numeric>
#include <set>

#include "server/core/try.h"
#include "server/diagnosis/diagnose.h"
#include "server/formats/csv/dataset_csv.h"
#include "server/formats/formula/formula.h"
#include "tests/hidden_effects/accepting/foreign_truth.h"
#include "tests/hidden_effects/foreign/dataset.h"

namespace driftwise::hidden {
namespace {

constexpr CellTime kForeignZero{1'600'000'000'000'000'000};

Result<diagnosis::Diagnosis> diagnosed_as_cli(const Dataset& data, const std::string& baseline,
                                              int nulls) {
  diagnosis::DiagnoseOptions options;
  DRIFTWISE_TRY(const auto formula, formats::Formula::parse(baseline));
  DRIFTWISE_TRY(auto candidates, formula.expand(data));
  options.baseline = std::move(candidates);
  options.nulls = nulls;
  return diagnosis::diagnose(data, options);
}

double mean_of(const std::vector<double>& errors) {
  return std::accumulate(errors.begin(), errors.end(), 0.0) /
         static_cast<double>(std::max<std::size_t>(errors.size(), 1));
}

std::vector<double> inside_of(const std::vector<double>& errors,
                              const std::vector<std::uint8_t>& inside) {
  std::vector<double> kept;
  for (std::size_t i = 0; i < errors.size(); ++i)
    if (inside[i] != 0) kept.push_back(errors[i]);
  return kept;
}

std::vector<OutputErrors> compared(const calibration::Model& model, const ServedErrors& before,
                                   const ServedErrors& after) {
  std::vector<OutputErrors> outputs;
  for (std::size_t o = 0; o < before.nm.size(); ++o)
    outputs.push_back({model.outputs[o].channel.symbol, rms_of(before.nm[o]), rms_of(after.nm[o]),
                       mean_of(before.nm[o]), mean_of(after.nm[o]),
                       rms_of(inside_of(before.nm[o], before.inside)),
                       rms_of(inside_of(after.nm[o], before.inside))});
  return outputs;
}

std::string changes_of(const application::ExtensionPlan& plan) {
  std::string text;
  const auto say = [&](const std::string& what) { text += (text.empty() ? "" : ", ") + what; };
  for (const auto& shift : plan.amendment.shifts) say(shift.axis + " is corrected");
  for (const auto& split : plan.amendment.splits)
    say("the datum is split at row " + std::to_string(split.row + 1));
  for (const auto& sensor : plan.amendment.sensors) say(sensor.symbol + " is left out");
  for (const auto& out : plan.exclusions)
    say(std::to_string(out.rows.size()) + " rows are kept out");
  return text;
}

void note_error(ForeignCase& one, const std::string& outcome, const Error& error) {
  one.outcome = outcome;
  one.reason = error.reason;
  one.message = error.message;
}

void note_findings(ForeignCase& one, const foreign::Generated& made,
                   const diagnosis::Diagnosis& found) {
  one.verdict = diagnosis::to_string(found.verdict);
  one.named = names_of(found);
  std::multiset<std::string> named, hidden;
  for (const auto& finding : found.findings) {
    named.insert(finding.cause);
    one.one_of_a_set |= !finding.indistinguishable_from.empty();
  }
  for (const auto& truth : made.truths) hidden.insert(truth.cause);
  one.named_right = named == hidden;
}

// Baseline and accepted model, served and compared.
void judge_served(ForeignCase& one, const foreign::Generated& made, const Dataset& data,
                  const std::string& baseline, const diagnosis::Diagnosis& found) {
  const CellDescription cell;
  const auto model = accepted_fit(data, baseline);
  if (!model) return note_error(one, "not_served", model.error());
  const auto robots = foreign_truth(made, data, kForeignZero, UnlistedEffectOf::robot);
  const auto before = served_errors(*model, cell, data, robots);
  if (!before) return note_error(one, "not_served", before.error());
  one.rows_judged = static_cast<int>(before->inside.size());
  one.rows_inside = static_cast<int>(std::ranges::count(before->inside, 1));
  const auto accepted = accept_all(found, data, kForeignZero);
  if (!accepted) return note_error(one, "refused", accepted.error());
  one.formula = accepted->plan.formula;
  one.changed = changes_of(accepted->plan);
  const auto after = served_errors(accepted->model, cell, data, robots);
  if (!after) return note_error(one, "refused", after.error());
  one.outcome = "accepted";
  one.outputs = compared(*model, *before, *after);
  if (reads_motors(accepted->model))
    if (const auto moving =
            served_errors(accepted->model, cell, data, robots, AskedWhen::before_the_move))
      one.outputs_before_move = compared(*model, *before, *moving);
  if (made.order.kind != "unlisted") return;
  const auto instruments = foreign_truth(made, data, kForeignZero, UnlistedEffectOf::instruments);
  const auto before_too = served_errors(*model, cell, data, instruments);
  const auto after_too = served_errors(accepted->model, cell, data, instruments);
  if (before_too && after_too)
    one.outputs_as_instrument = compared(*model, *before_too, *after_too);
}

void judge_generated(ForeignCase& one, const foreign::Generated& made, int nulls) {
  const auto& campaign = made.campaign;
  const auto dress = foreign::dress_of(made);
  one.robot = campaign.robot.kind;
  one.plan = campaign.plan;
  one.noise = campaign.noise.kind;
  one.axes = campaign.robot.axes;
  one.rows = campaign.rows();
  for (const auto& truth : made.truths)
    one.hidden.push_back(truth.cause + (truth.subject.empty() ? "" : " " + truth.subject));
  auto data = formats::read_dataset_csv(foreign::dataset_csv(made, dress), "foreign.csv");
  if (!data) return note_error(one, "not_diagnosed", data.error());
  const bool held_out = holds_rows_out(*data);
  one.judged_on = held_out ? "validation" : "withheld";
  if (!held_out) withhold_rows(*data);
  const auto baseline = foreign::baseline_formula(made, dress);
  one.formula = baseline;
  const auto found = diagnosed_as_cli(*data, baseline, nulls);
  if (!found) return note_error(one, "not_diagnosed", found.error());
  note_findings(one, made, *found);
  one.outcome = "nothing_found";
  if (!found->findings.empty()) judge_served(one, made, *data, baseline, *found);
}

double figure(const OutputErrors& one, bool after, bool inside_only) {
  if (inside_only) return after ? one.inside_after_nm : one.inside_before_nm;
  return after ? one.after_nm : one.before_nm;
}

}  // namespace

ForeignCase judged_case(const NumberedOrder& ordered, int nulls) {
  ForeignCase one;
  one.number = ordered.number;
  one.order = ordered.order;
  const std::clock_t begin = std::clock();
  try {
    judge_generated(one, foreign::generate(ordered.order), nulls);
  } catch (const std::runtime_error& error) {  // no draw has this strength
    one.outcome = "not_generated";
    one.message = error.what();
  }
  one.cpu_s = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  return one;
}

double ratio_of(const std::vector<OutputErrors>& outputs, bool inside_only) {
  double before = 0, after = 0;
  for (const auto& output : outputs) {
    before += std::pow(figure(output, false, inside_only), 2);
    after += std::pow(figure(output, true, inside_only), 2);
  }
  return before > 0 ? std::sqrt(after / before) : 1.0;
}

bool has_harm(const std::vector<OutputErrors>& outputs, bool inside_only) {
  return std::ranges::any_of(outputs, [&](const OutputErrors& one) {
    return is_harmed(figure(one, false, inside_only), figure(one, true, inside_only));
  });
}

}  // namespace driftwise::hidden
