#include "server/calibration/report/accuracy.h"

namespace driftwise::calibration {
namespace {

std::vector<JudgedAccuracy> all_of(const Model& model) {
  std::vector<JudgedAccuracy> all;
  for (const auto& output : model.outputs)
    for (auto& one : judged_accuracies(output, model.lineage)) all.push_back(std::move(one));
  return all;
}

// An extension's rows are those of its parent's runs with a correction in them: another hash.
bool have_same_rows(const Lineage& one, const Lineage& other) {
  const bool same_data = one.runs.empty()
                             ? !one.dataset_hash.empty() && one.dataset_hash == other.dataset_hash
                             : one.runs == other.runs;
  return same_data && one.exclusions_hash == other.exclusions_hash &&
         one.rows_calibration == other.rows_calibration &&
         one.rows_validation == other.rows_validation;
}

}  // namespace

std::vector<JudgedAccuracy> judged_accuracies(const OutputModel& output, const Lineage& lineage) {
  const SummaryUnit summary = summary_unit(output.channel.unit);
  const auto& a = output.accuracy;
  std::vector<JudgedAccuracy> judged;
  const auto add = [&](JudgedRows rows, std::int64_t count, double mean, double u90, double a90) {
    judged.push_back({output.channel.symbol,
                      summary.unit,
                      rows,
                      {.rows = count,
                       .mean = mean * summary.factor,
                       .u90 = u90 * summary.factor,
                       .a90 = a90 * summary.factor}});
  };
  if (a.a90_validation)
    add(JudgedRows::validation, lineage.rows_validation, a.mean_validation.value_or(0),
        a.u90_validation.value_or(0), *a.a90_validation);
  if (a.a90_blocks)
    add(JudgedRows::blocks, lineage.rows_calibration, a.mean_blocks.value_or(0),
        a.u90_blocks.value_or(0), *a.a90_blocks);
  add(JudgedRows::calibration, lineage.rows_calibration, a.mean_calibration, a.u90_calibration,
      a.a90_calibration);
  return judged;
}

std::vector<JudgedAccuracy> heading_of(const Model& model) {
  return driftwise::heading_of(all_of(model));
}

std::vector<JudgedAccuracy> heading_of(const Model& model, const Model& before) {
  auto heading = heading_of(model);
  if (!have_same_rows(model.lineage, before.lineage)) return heading;
  for (auto& one : heading)
    for (const auto& earlier : all_of(before))
      if (earlier.output == one.output && earlier.rows == one.rows && earlier.unit == one.unit)
        one.before = earlier.figures;
  return heading;
}

}  // namespace driftwise::calibration
