#include "server/calibration/fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <limits>
#include <map>
#include <set>
#include <span>

#include "server/calibration/datum_zeros.h"
#include "server/calibration/design/design.h"
#include "server/calibration/design/predict.h"
#include "server/calibration/linear/rank.h"
#include "server/calibration/linear/row_reduction.h"
#include "server/calibration/linear/tail.h"
#include "server/calibration/noise/serial_errors.h"
#include "server/calibration/placed_terms.h"
#include "server/calibration/report/enough_rows.h"
#include "server/calibration/report/held_out.h"
#include "server/calibration/report/influence.h"
#include "server/calibration/report/part_warnings.h"
#include "server/calibration/report/report.h"
#include "server/calibration/report/residual_statistics.h"
#include "server/calibration/report/served_digits.h"
#include "server/calibration/report/set_overlap.h"
#include "server/calibration/selection/selected.h"
#include "server/calibration/selection/selection_rule.h"
#include "server/core/data/accuracy.h"
#include "server/core/data/unusable_values.h"
#include "server/core/try.h"
#include "server/effects/term_order.h"

namespace driftwise::calibration {
namespace {

using Eigen::Index;

constexpr std::int64_t kLeastJudges = 2;  // validation rows: fewer have no figures

// The largest departure of each term from its mean over the calibration rows.
void add_largest_contributions(const std::vector<TermRange>& ranges, OutputModel& model) {
  std::size_t in = 0;
  for (auto& report : model.report) {
    if (!report.in) continue;
    const auto& range = ranges[in++];
    if (!report.term.is_constant())
      report.contribution_max =
          std::abs(report.coefficient) * std::max(range.high - range.mean, range.mean - range.low);
  }
}

// Whether the triangles of a held-out block's pieces are small beside their rows: then the fit
// itself is put together from them, and the rows are reduced once.
bool shares_pieces(const Design& design, const std::vector<Index>& cuts) {
  return !cuts.empty() &&
         design.row_count() >= 4 * design.width() * static_cast<Index>(cuts.size() - 1);
}

Eigen::VectorXd values_at(const Eigen::VectorXd& all, const std::vector<std::size_t>& rows) {
  Eigen::VectorXd some(static_cast<Index>(rows.size()));
  for (std::size_t i = 0; i < rows.size(); ++i)
    some[static_cast<Index>(i)] = all[static_cast<Index>(rows[i])];
  return some;
}

// Rows marked validation whose datum has a constant in the model.
std::vector<std::size_t> validation_rows(const Design& design, const Dataset& dataset,
                                         const Eigen::VectorXd& errors, std::int64_t& no_datum) {
  const std::set<int> known(design.datum.begin(), design.datum.end());
  const auto ordinals = datum_ordinals(dataset);
  std::vector<std::size_t> rows;
  no_datum = 0;
  for (std::size_t row = 0; row < dataset.rows; ++row) {
    if (dataset.set_of(row) != PointSet::validation || dataset.is_excluded(row) ||
        std::isnan(errors[static_cast<Index>(row)]))
      continue;
    if (design.constant && !known.contains(static_cast<int>(ordinals[row])))
      ++no_datum;
    else
      rows.push_back(row);
  }
  return rows;
}

void add_accuracy(const Design& design, const Eigen::VectorXd& residuals, const Solution& solution,
                  Index output, Accuracy& accuracy) {
  const ErrorFigures figures =
      error_figures(std::span(residuals.data(), static_cast<std::size_t>(residuals.size())));
  accuracy.u90_calibration = figures.u90;
  accuracy.mean_calibration = figures.mean;
  accuracy.a90_calibration = figures.a90;
  accuracy.lag1_autocorrelation = lag1_autocorrelation(residuals);
  accuracy.effective_rows = effective_rows(residuals.size(), accuracy.lag1_autocorrelation);
  const auto pure = pure_error(design, output, residuals);
  if (!pure) return;
  accuracy.pure_error = pure->sd;
  if (!pure->exact || !(pure->sd > 0) || solution.dof <= pure->dof) return;
  const double pure_squares = pure->sd * pure->sd * pure->dof;
  const int dof = solution.dof - pure->dof;
  accuracy.lack_of_fit_f = std::max(0.0, solution.rss - pure_squares) / dof / (pure->sd * pure->sd);
  accuracy.lack_of_fit_p = f_upper_p(*accuracy.lack_of_fit_f, dof, pure->dof);
}

// By name, in the order of their first row. Empty: none of the rows has a name.
std::vector<SetAccuracy> by_validation_set(const Eigen::VectorXd& errors,
                                           const std::vector<std::size_t>& validation,
                                           const std::vector<std::string>& names) {
  std::vector<std::pair<std::string, std::vector<double>>> sets;
  bool any = false;
  for (const std::size_t row : validation) {
    if (row >= names.size()) return {};
    any = any || names[row] != "validation";
    auto set =
        std::ranges::find(sets, names[row], &std::pair<std::string, std::vector<double>>::first);
    if (set == sets.end()) set = sets.insert(sets.end(), {names[row], {}});
    set->second.push_back(errors[static_cast<Index>(row)]);
  }
  std::vector<SetAccuracy> out;
  if (any)
    for (const auto& [name, of_set] : sets) out.push_back({name, error_figures(of_set)});
  return out;
}

// Validation rows, and blocks of time held out; the rows' errors where there are not too many.
void add_held_out(const Design& design, const Dataset& dataset, const Eigen::VectorXd& errors,
                  const std::vector<std::size_t>& validation, const BlockResult& blocks,
                  OutputModel& output) {
  Accuracy& accuracy = output.accuracy;
  const Eigen::VectorXd on_validation = values_at(errors, validation);
  if (std::ssize(validation) >= kLeastJudges) {
    const ErrorFigures figures = error_figures(
        std::span(on_validation.data(), static_cast<std::size_t>(on_validation.size())));
    accuracy.u90_validation = figures.u90;
    accuracy.mean_validation = figures.mean;
    accuracy.a90_validation = figures.a90;
  }
  if (blocks) {
    const HeldOut& held = blocks->figure;
    accuracy.u90_blocks = held.figures.u90;
    accuracy.mean_blocks = held.figures.mean;
    accuracy.a90_blocks = held.figures.a90;
    accuracy.u90_blocks_low = held.u90_low;
    accuracy.u90_blocks_high = held.u90_high;
    accuracy.a90_blocks_low = held.low;
    accuracy.a90_blocks_high = held.high;
    accuracy.block_count = held.folds;
  }
  if (dataset.rows > kMostHeldOutRows || (std::ssize(validation) < kLeastJudges && !blocks)) return;
  output.held_out.assign(dataset.rows, std::nan(""));
  if (std::ssize(validation) >= kLeastJudges)
    for (const std::size_t row : validation) output.held_out[row] = errors[static_cast<Index>(row)];
  if (blocks)
    for (std::size_t i = 0; i < design.rows.size(); ++i)
      output.held_out[design.rows[i]] = blocks->errors[i];
}

// The noise of the rows.
NoiseSpectrum add_serial_errors(const Design& design, const Eigen::VectorXd& residuals,
                                const Selection& selection, const Solution& solution,
                                OutputModel& output) {
  if (solution.dof > 0)
    output.covariance_root = std::sqrt(solution.rss / solution.dof) * solution.root;
  if (selection.exact) return {};  // rounding errors are no series
  SerialErrors errors = serial_errors(design, solution, residuals);
  output.covariance_serial = std::move(errors.covariance);
  if (errors.root.size() > 0) output.covariance_root = std::move(errors.root);
  output.accuracy.slow_share = errors.noise.share;
  output.accuracy.slow_rows = errors.noise.rows;
  Index in = 0;
  for (auto& report : output.report)
    if (report.in) report.standard_error_serial = errors.standard_errors[in++];
  output.noise_variance = errors.spectrum.variance();
  return std::move(errors.spectrum);
}

std::vector<ChannelRange> domain_of(const Design& design, const Dataset& dataset,
                                    const std::vector<OutputModel>& outputs) {
  std::vector<std::string> symbols;
  for (const auto& output : outputs)
    for (const auto& term : output.terms)
      for (const auto& symbol : effects::symbols_of(term))
        if (std::ranges::find(symbols, symbol) == symbols.end()) symbols.push_back(symbol);
  std::vector<ChannelRange> domain;
  const auto add = [&](const Channel& channel) {
    if (std::ranges::find(symbols, channel.symbol) == symbols.end()) return;
    const auto values = dataset.values_of(channel.symbol);
    ChannelRange range{channel, HUGE_VAL, -HUGE_VAL};
    for (const std::size_t row : design.rows) {
      range.min = std::min(range.min, values[row]);
      range.max = std::max(range.max, values[row]);
    }
    domain.push_back(range);
  };
  for (const auto& column : dataset.columns) add(column.channel);
  if (!dataset.dwell_s.empty()) add({"dwell", "s"});
  return domain;
}

// Returns the sentences of terms that hardly vary: said here once, not again for every output.
std::set<std::string> general_warnings(const Design& design, const FitOptions& options,
                                       const SelectionRule& rule, std::int64_t no_datum,
                                       Model& model) {
  auto& warnings = model.warnings;
  if (design.dropped > 0)
    warnings.push_back(std::to_string(design.dropped) + " rows dropped for missing values");
  if (no_datum > 0)
    warnings.push_back(
        std::to_string(no_datum) +
        " validation rows left out: their datum has no calibration rows to take its constant from");
  std::set<std::string> hardly_vary;
  for (int j = 0; j < static_cast<int>(design.terms.size()); ++j) {
    if (design.terms[static_cast<std::size_t>(j)].is_constant()) continue;
    const std::string sentence = constant_sentence(design, j);
    if (!sentence.empty() && hardly_vary.insert(sentence).second)
      warnings.push_back(sentence + ": these rows say nothing about it");
  }
  for (const auto& sentence : barred_sentences(design, rule)) warnings.push_back(sentence);
  if (options.select == Select::stepwise)
    warnings.push_back(
        "p-values after selection are not error probabilities, and the uncertainty of a target "
        "holds nothing of what the selection adds: trust the held-out figures");
  return hardly_vary;
}

// What became of the further datums.
std::string datum_note(const DatumZero& zero) {
  const std::string name = "datum " + std::to_string(zero.ordinal);
  if (zero.pose.empty())
    return name +
           " has a constant of its own and is not moved to where its zero lies: " + zero.why_not;
  std::string at;
  for (const auto& [channel, value] : zero.pose) {
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), " %s = %.6g", channel.c_str(), value);
    at += (at.empty() ? "" : ",") + std::string(text.data());
  }
  return "the zero of " + name + " lies at" + at + " of the first: its rows are fitted there";
}

// Per output and column: 1 for a placed term in an output that is not among its own. Empty: none.
std::vector<std::vector<char>> left_out_of(const Design& design,
                                           const std::vector<PlacedTerm>& placed) {
  std::vector<std::vector<char>> out;
  if (placed.empty()) return out;
  for (const auto& channel : design.outputs) {
    auto& of_output = out.emplace_back(design.terms.size(), 0);
    for (const auto& one : placed)
      if (std::ranges::find(one.outputs, channel.symbol) == one.outputs.end())
        for (std::size_t j = 0; j < design.terms.size(); ++j)
          if (design.terms[j] == effects::canonical(one.term)) of_output[j] = 1;
  }
  return out;
}

// The rows as they are, every datum with its constant.
Result<Model> fit_rows(const Dataset& dataset, const FitOptions& options,
                       const std::vector<PlacedTerm>& placed) {
  DRIFTWISE_TRY(auto prepared, make_design(dataset, options));
  DRIFTWISE_TRY(auto asked, selection_rule(options, prepared));
  asked.left_out = left_out_of(prepared, placed);
  const SelectionRule& rule = asked;
  const Design& design = prepared;
  DRIFTWISE_RETURN_IF_ERROR(check_enough_rows(dataset, design, options));
  DRIFTWISE_RETURN_IF_ERROR(check_sets_apart(dataset, design));

  const double start_us = options.stopwatch_us ? options.stopwatch_us() : 0;
  const auto cuts = block_cuts(design, options.blocks, options.block_gap);
  const bool shared = shares_pieces(design, cuts);
  const RowReduction whole(design, shared ? cuts : std::vector<Index>{0, design.row_count()},
                           options.solver, options.executor);
  const Triangle triangle = whole.all();
  DRIFTWISE_TRY(auto fitted, select_and_solve(design, triangle, rule, options.executor));
  const double took_us = options.stopwatch_us ? options.stopwatch_us() - start_us : 0;

  Model model;
  model.formula = options.candidates.formula;
  model.select = options.select == Select::stepwise ? "stepwise" : "all";
  model.criterion = to_string(options.criterion);
  model.hierarchy = options.hierarchy;
  model.starts = options.starts;
  model.seed = options.seed;
  model.p_enter = options.p_enter;
  model.p_remove = options.p_remove;
  model.fit_us = took_us;
  model.lineage = options.lineage;
  model.lineage.rows_calibration = static_cast<std::int64_t>(design.rows.size());
  model.lineage.rows_dropped = design.dropped;
  model.lineage.rows_excluded = design.excluded;
  model.lineage.measured_by = measured_by_from(dataset.metadata);

  const auto held_out =
      cuts.empty() ? std::vector<BlockResult>(design.outputs.size(), tl::unexpected(std::string()))
      : shared
          ? held_out_by_blocks(design, whole, rule, options.executor)
          : held_out_by_blocks(design, RowReduction(design, cuts, whole.solver(), options.executor),
                               rule, options.executor);
  std::int64_t no_datum = 0;
  std::vector<std::string> warnings;
  std::int64_t judged = std::numeric_limits<std::int64_t>::max();  // of the output with the fewest
  for (std::size_t o = 0; o < fitted.size(); ++o) {
    const auto& [selection, starts, solution] = fitted[o];
    OutputModel output =
        describe_output(design, triangle, selection, solution, static_cast<Index>(o));
    output.starts = starts;
    DRIFTWISE_TRY(const auto predicted,
                  predict_and_range(dataset, output, design.rows, options.executor));
    add_largest_contributions(predicted.terms, output);
    const auto& measured = dataset.find(output.channel.symbol)->values;
    const Eigen::VectorXd errors =
        Eigen::Map<const Eigen::VectorXd>(measured.data(), static_cast<Index>(measured.size())) -
        predicted.output;
    const Eigen::VectorXd residuals = values_at(errors, design.rows);
    DRIFTWISE_RETURN_IF_ERROR(check_served_digits(design, solution, residuals, output));
    add_accuracy(design, residuals, solution, static_cast<Index>(o), output.accuracy);
    const auto noise = add_serial_errors(design, residuals, selection, solution, output);
    DRIFTWISE_RETURN_IF_ERROR(
        add_influences(dataset, design.rows, options.weight_symbol, noise, output));
    const auto validation = validation_rows(design, dataset, errors, no_datum);
    judged = std::min(judged, static_cast<std::int64_t>(validation.size()));
    output.accuracy.validation_sets = by_validation_set(errors, validation, options.set_names);
    add_held_out(design, dataset, errors, validation, held_out[o], output);
    if (!held_out[o] && !held_out[o].error().empty())
      warnings.push_back(output.channel.symbol +
                         ": no figure of held-out blocks of time: " + held_out[o].error());
    for (auto& sentence : output_warnings(triangle, selection, output))
      warnings.push_back(std::move(sentence));
    model.outputs.push_back(std::move(output));
  }
  // Complete, and of a datum that the model knows.
  model.lineage.rows_validation = judged < kLeastJudges ? 0 : std::min(judged, design.validation);
  if (!whole.note().empty()) model.warnings.push_back(whole.note());
  model.domain = domain_of(design, dataset, model.outputs);
  if (auto sparse = sparse_readings(dataset, design.rows, model.outputs))
    model.warnings.push_back(std::move(*sparse));
  const auto said = general_warnings(design, options, rule, no_datum, model);
  std::ranges::copy_if(warnings, std::back_inserter(model.warnings), [&said](const auto& warning) {
    const auto colon = warning.find(": ");  // after the output's name
    return colon == std::string::npos || !said.contains(warning.substr(colon + 2));
  });
  return model;
}

}  // namespace

Result<Model> fit(const Dataset& dataset, const FitOptions& options) {
  return fit(dataset, options, {});
}

Result<Model> fit(const Dataset& dataset, const FitOptions& options,
                  const std::vector<PlacedTerm>& placed) {
  if (const auto usable = without_unusable(dataset)) {
    auto model = fit(usable->data, options, placed);
    if (!model) {
      Error error = model.error();
      error.message += "; " + usable->sentence;
      return tl::unexpected(std::move(error));
    }
    model->warnings.insert(model->warnings.begin(), usable->sentence);
    return model;
  }
  DRIFTWISE_RETURN_IF_ERROR(check_options(options));
  const double start_us = options.stopwatch_us ? options.stopwatch_us() : 0;
  auto zeros = find_datum_zeros(dataset, options);
  const double took_us = options.stopwatch_us ? options.stopwatch_us() - start_us : 0;
  auto model = any_moved(zeros) ? fit_rows(in_first_datum(dataset, zeros), options, placed)
                                : fit_rows(dataset, options, placed);
  if (!model) return model;
  for (const auto& zero : zeros) model->warnings.push_back(datum_note(zero));
  for (auto& sentence : part_warnings(dataset, *model))
    model->warnings.push_back(std::move(sentence));
  model->datum_zeros = std::move(zeros);
  if (!model->datum_zeros.empty()) model->fit_us += took_us;
  return model;
}

}  // namespace driftwise::calibration
