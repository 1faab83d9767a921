#include "tests/hidden_effects/accepting/served_truth.h"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <numeric>

#include "server/application/diagnoses/extension_fit.h"
#include "server/application/models/fit_options.h"
#include "server/compensation/snapshot_builder.h"
#include "server/compensation/target.h"
#include "server/core/channel.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/core/units.h"
#include "server/effects/term_order.h"
#include "server/formats/model/model_json.h"

namespace driftwise::hidden {
namespace {

constexpr double kToleratedShare = 0.05, kTolerated_nm = 1.0;

std::vector<RunId> runs_of(const application::RunsData& data) {
  std::vector<RunId> runs;
  for (const auto& origin : data.origins)
    if (std::ranges::find(runs, origin.run) == runs.end()) runs.push_back(origin.run);
  return runs;
}

Result<calibration::Model> fitted(const application::RunsData& data, const std::string& formula) {
  application::FitRequest fit;
  fit.runs = runs_of(data);
  fit.formula = formula;
  fit.select = "all";
  auto record = application::fit_record(data.data, fit, application::source_of(fit));
  if (!record && record.error().reason == reasons::kRankDeficient) {
    fit.select = "stepwise";
    record = application::fit_record(data.data, fit, application::source_of(fit));
  }
  DRIFTWISE_RETURN_IF_ERROR(record);
  return formats::read_model_json(record->json);
}

struct SeenInRow {
  std::vector<ChannelValue> conditions, motors;
};

SeenInRow seen_in(const Dataset& data, std::size_t row) {
  SeenInRow seen;
  for (const auto& column : data.columns) {
    const auto& symbol = column.channel.symbol;
    if (is_pose_symbol(symbol)) continue;
    (is_motor_symbol(symbol) ? seen.motors : seen.conditions)
        .push_back({column.channel.name(), column.values[row]});
  }
  return seen;
}

Result<void> anchor_at_zero(compensation::SnapshotBuilder& builder, const SeenInRow& seen,
                            const std::vector<double>& zero_motor_mm) {
  auto values = seen.conditions;
  for (std::size_t k = 0; k < zero_motor_mm.size(); ++k)
    values.push_back({"q" + std::to_string(k + 1) + "_mm", zero_motor_mm[k]});
  return builder.anchor(values);
}

bool lies_outside(const compensation::Snapshot& snapshot, const compensation::Target& target) {
  for (std::size_t k = 0; k < snapshot.inputs.size(); ++k)
    if (snapshot.inputs[k].variable && ((target.outside >> k) & 1) != 0) return true;
  return false;
}

}  // namespace

application::RunsData as_runs(const Dataset& data, CellTime time_zero) {
  application::RunsData runs{data, {}, time_zero};
  for (std::size_t row = 0; row < data.rows; ++row)
    runs.origins.push_back(
        {RunId{data.run.empty() ? 1 : data.run[row]}, static_cast<std::int64_t>(row)});
  return runs;
}

Result<calibration::Model> accepted_fit(const Dataset& data, const std::string& formula) {
  return fitted(as_runs(data, CellTime{}), formula);
}

Result<AcceptedModel> accept_all(const diagnosis::Diagnosis& found, const Dataset& data,
                                 CellTime time_zero) {
  std::vector<int> all(found.findings.size());
  std::iota(all.begin(), all.end(), 1);
  std::erase_if(all, [&](int number) {  // what cannot be accepted, as the daemon leaves it out
    return diagnosis::correction_is_uncertain(found.findings[static_cast<std::size_t>(number - 1)]);
  });
  if (all.empty())
    return fail(ErrorCode::failed_precondition, reasons::kNothingFound, "nothing to make");
  auto runs = as_runs(data, time_zero);
  const auto told = application::with_known_side(found, all, runs);
  // Nobody is there to say whose deviation the others are: as the daemon answers then.
  DRIFTWISE_TRY(auto chosen, application::chosen_findings(found, told.empty() ? all : told));
  DRIFTWISE_TRY(auto plan, application::plan_extension(DiagnosisId{1}, found, chosen, runs));
  DRIFTWISE_RETURN_IF_ERROR(application::put_in_force(plan, runs));
  application::FitRequest fit;
  fit.runs = runs_of(runs);
  fit.select = "all";
  DRIFTWISE_TRY(const auto record, application::fit_extension(plan, runs.data, std::move(fit)));
  DRIFTWISE_TRY(auto model, formats::read_model_json(record.json));
  return AcceptedModel{std::move(plan), std::move(model)};
}

Result<ServedErrors> served_errors(const calibration::Model& model, const CellDescription& cell,
                                   const Dataset& data, const TrueRows& truth, AskedWhen when) {
  DRIFTWISE_TRY(auto builder, compensation::SnapshotBuilder::create(model, ModelId{1}, cell));
  ServedErrors errors;
  errors.nm.resize(model.outputs.size());
  if (truth.zero_motor_mm.empty()) builder.keep_model_datum();
  for (std::size_t row = 0; row < data.rows; ++row) {
    const CellTime at = truth.time_zero + nanoseconds_from_s(truth.time_s[row]);
    const auto seen = seen_in(data, row);
    auto first_seen = seen.conditions;
    if (when == AskedWhen::on_arrival || row == 0)
      first_seen.insert(first_seen.end(), seen.motors.begin(), seen.motors.end());
    builder.observe(first_seen, at);
    if (row == 0 && !truth.zero_motor_mm.empty())  // seconds after the zero: its temperatures
      DRIFTWISE_RETURN_IF_ERROR(anchor_at_zero(builder, seen, truth.zero_motor_mm));
    if (truth.judged[row] != 0) {
      compensation::TargetRequest request;
      for (const auto& [variable, values] : truth.asked) request.set(variable, values[row]);
      const auto snapshot = builder.build(at);
      const auto target = compensation::compute_target(snapshot, request);
      if (target.refusal != compensation::Refusal::none)
        return tl::unexpected(compensation::refusal_error(snapshot, target));
      for (std::size_t o = 0; o < target.outputs; ++o)
        errors.nm[o].push_back(nm_from_mm(target.q_mm[o] - truth.motor_mm[o][row]));
      errors.inside.push_back(lies_outside(snapshot, target) ? 0 : 1);
    }
    if (when == AskedWhen::before_the_move && row > 0) builder.observe(seen.motors, at);
  }
  return errors;
}

bool reads_motors(const calibration::Model& model) {
  for (const auto& output : model.outputs)
    for (const auto& term : output.terms)
      for (const auto& symbol : effects::symbols_of(term))
        if (is_motor_symbol(symbol)) return true;
  return false;
}

std::string names_of(const diagnosis::Diagnosis& found) {
  std::string text;
  for (const auto& finding : found.findings)
    text += (text.empty() ? "" : " + ") + finding.cause +
            (finding.subject.empty() ? "" : " " + finding.subject);
  return text;
}

double rms_of(const std::vector<double>& errors) {
  const double sum = std::inner_product(errors.begin(), errors.end(), errors.begin(), 0.0);
  return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(errors.size(), 1)));
}

bool is_harmed(double before_rms_nm, double after_rms_nm) {
  return after_rms_nm - before_rms_nm > std::max(kToleratedShare * before_rms_nm, kTolerated_nm);
}

MeanRatio mean_ratio(const std::vector<double>& ratios, double confidence) {
  const auto n = static_cast<double>(ratios.size());
  double sum = 0, square = 0;
  for (const double one : ratios) sum += std::log(one);
  const double mean = sum / n;
  for (const double one : ratios) square += (std::log(one) - mean) * (std::log(one) - mean);
  const double se = std::sqrt(square / (n - 1) / n);
  const double t = boost::math::quantile(boost::math::students_t(n - 1), 0.5 + 0.5 * confidence);
  return {std::exp(mean), std::exp(mean - t * se), std::exp(mean + t * se)};
}

}  // namespace driftwise::hidden
