#include "server/rpc/model/convert_residuals.h"

#include <algorithm>
#include <map>

#include "server/core/data/accuracy.h"
#include "server/core/data/row_marks.h"
#include "server/core/units.h"
#include "server/effects/effect.h"
#include "server/rpc/shared/convert_accuracy.h"
#include "server/rpc/shared/convert_values.h"

namespace driftwise::rpc {
namespace {

template <class Values, class Field>
void take_every(const Values& values, std::size_t step, Field& out) {
  out.Reserve(static_cast<int>(values.size() / step + 1));
  for (std::size_t row = 0; row < values.size(); row += step)
    out.Add(static_cast<typename Field::value_type>(values[row]));
}

// A set with no name but "validation" is one of them where others have names.
void add_named_sets(const application::ModelResiduals& residuals,
                    const application::ModelResiduals::Output& output,
                    v1::ListResidualsResponse::Output& out) {
  std::vector<std::string> names;
  std::map<std::string, std::vector<double>> errors;
  for (std::size_t row = 0; row < residuals.sets.size(); ++row) {
    const auto& name = residuals.sets[row];
    if (residuals.data.set_of(row) != PointSet::validation || residuals.data.is_excluded(row))
      continue;
    auto& of_set = errors[name];
    if (of_set.empty()) names.push_back(name);
    of_set.push_back(output.values[row]);
  }
  for (const auto& name : names) {
    auto& added = *out.add_named_sets();
    added.set_name(name);
    *added.mutable_figures() = figures_from(error_figures(errors[name]));
  }
}

}  // namespace

v1::CheckFormulaResponse formula_check_from(const application::FormulaCheck& check) {
  v1::CheckFormulaResponse out;
  out.set_problem(check.problem);
  if (check.problem_offset) out.set_problem_offset(static_cast<int>(*check.problem_offset));
  out.set_canonical(check.canonical);
  out.mutable_outputs()->Add(check.outputs.begin(), check.outputs.end());
  out.mutable_terms()->Add(check.terms.begin(), check.terms.end());
  out.set_calibration_row_count(check.calibration);
  out.set_validation_row_count(check.validation);
  out.set_dropped_row_count(check.dropped);
  out.set_rank(check.rank);
  out.set_column_count(check.columns);
  out.mutable_look_alikes()->Add(check.look_alikes.begin(), check.look_alikes.end());
  for (const auto& channel : check.channels) {
    auto& added = *out.add_channels();
    added.set_symbol(channel.symbol);
    added.set_unit(channel.unit);
  }
  for (const auto& kind : effects::effect_kinds()) {
    auto& added = *out.add_effects();
    added.set_name(kind.name);
    added.set_usage(effects::usage(kind));
    added.set_sentence(kind.sentence);
    added.set_cause(kind.catalogue_id);
  }
  return out;
}

v1::ListResidualsResponse residuals_from(const application::ModelResiduals& residuals) {
  constexpr std::size_t kMostNumbers = 400'000;
  const Dataset& data = residuals.data;
  const std::size_t columns = data.columns.size() + 2 * residuals.outputs.size() + 8;
  const std::size_t step = data.rows * columns / kMostNumbers + 1;
  v1::ListResidualsResponse out;
  take_every(data.time_s, step, *out.mutable_time_s());
  take_every(data.line, step, *out.mutable_line());
  take_every(data.zero, step, *out.mutable_zero());
  const bool any_passage = std::ranges::find(data.excluded, kPassageRow) != data.excluded.end();
  for (std::size_t row = 0; row < data.rows; row += step) {
    out.add_validation(data.set_of(row) == PointSet::validation);
    out.add_excluded(data.is_excluded(row));
    if (!residuals.sets.empty()) out.add_sets(residuals.sets[row]);
    if (any_passage) out.add_passage(is_passage(data, row));
    if (!residuals.origins.empty()) {
      out.add_row_runs(residuals.origins[row].run.value);
      out.add_rows(shown_row(residuals.origins[row].row));
    }
  }
  for (const auto& column : data.columns) {
    auto& added = *out.add_variables();
    added.set_symbol(column.channel.symbol);
    added.set_unit(column.channel.unit);
    take_every(column.values, step, *added.mutable_values());
  }
  for (const auto& output : residuals.outputs) {
    auto& added = *out.add_outputs();
    added.set_output(output.channel.symbol);
    added.set_unit(std::string(summary_unit(output.channel.unit).unit));
    take_every(output.values, step, *added.mutable_values());
    if (!output.held_out.empty()) take_every(output.held_out, step, *added.mutable_held_out());
    add_named_sets(residuals, output, added);
  }
  out.set_row_count(static_cast<std::int64_t>(data.rows));
  out.set_row_step(static_cast<std::int64_t>(step));
  out.set_dataset_hash(residuals.dataset_hash);
  out.set_same_rows(residuals.same_rows);
  for (const RunId run : residuals.mean_taken_out) out.add_runs_without_zero(run.value);
  return out;
}

}  // namespace driftwise::rpc
