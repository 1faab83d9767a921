#include "server/calibration/design/design.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>

#include "server/calibration/design/candidate_terms.h"
#include "server/core/data/overruns.h"
#include "server/core/data/row_marks.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/effects/direct_symbols.h"
#include "server/effects/term_evaluator.h"
#include "server/effects/term_order.h"

namespace driftwise::calibration {
namespace {

using effects::Term;

// The variables of a design as columns over all rows of the dataset.
struct Variables {
  std::vector<Variable> named;
  std::vector<std::span<const double>> values;
  std::vector<char> indicator;
  std::deque<std::vector<double>>
      storage;  // of effects and datum constants: what those values point into
  std::vector<std::string> stored_effects;  // by notation, in the order of storage
};

// Of a fit of runs the instant names the row: its place in the dataset is no row of a plan, for
// passages stand in between.
std::string row_text(const Dataset& dataset, const std::vector<RunId>& runs, std::size_t row) {
  if (!runs.empty() && !dataset.time_s.empty())
    return "run " + std::to_string(dataset.run.empty() ? runs.front().value : dataset.run[row]) +
           ", the row at time_s " + effects::number_text(dataset.time_s[row]) + " of its export";
  std::string text = "row " + std::to_string(row + 1);
  if (!dataset.time_s.empty())
    text += " (time_s " + effects::number_text(dataset.time_s[row]) + ")";
  return text;
}

Result<std::span<const double>> channel_values(const Dataset& dataset, const std::string& symbol,
                                               const std::string& why) {
  const auto values = dataset.values_of(symbol);
  if (!values.empty()) return values;
  std::string known;
  for (const auto& one : dataset.columns) known += (known.empty() ? "" : " ") + one.channel.symbol;
  return fail(ErrorCode::invalid_argument, reasons::kUnknownChannel,
              why + " needs channel '" + symbol + "', the data have: " + known);
}

std::vector<double> datum_column(const std::vector<double>& ordinals, int ordinal) {
  std::vector<double> column(ordinals.size());
  std::ranges::transform(ordinals, column.begin(),
                         [ordinal](double one) { return one == ordinal ? 1.0 : 0.0; });
  return column;
}

// One effect over the whole stream of rows, so that its memory sees every reading, used in the fit
// or not.
Result<std::vector<double>> effect_column(const Dataset& dataset, const effects::Call& call,
                                          const std::string& name) {
  if (effects::goes_along_path(call) && says_overruns(dataset)) {
    WholePath whole = with_overruns(dataset);
    whole.data.metadata.clear();
    DRIFTWISE_TRY(const auto along, effect_column(whole.data, call, name));
    std::vector<double> column;
    for (const std::size_t row : whole.kept) column.push_back(along[row]);
    return column;
  }
  std::vector<std::span<const double>> inputs;
  for (const auto& symbol : call.symbols) {
    DRIFTWISE_TRY(auto values, channel_values(dataset, symbol, name));
    inputs.push_back(values);
  }
  DRIFTWISE_TRY(auto evaluator, effects::TermEvaluator::create({Term{{call}}}, call.symbols));
  if (evaluator.has_memory() && dataset.time_s.empty())
    return fail(ErrorCode::invalid_argument, reasons::kUntimed,
                name + " needs to know when each row was measured: the data have no time_s column");
  const Eigen::MatrixXd column = evaluator.block(dataset.time_s, inputs, dataset.rows);
  return std::vector<double>(column.data(), column.data() + column.size());
}

struct Columns {
  Variables variables;
  std::vector<Monomial> monomials;  // one per term
};

// Effects by notation, worked out already: taken where they are needed.
using EffectColumns = std::map<std::string, std::vector<double>>;

Result<Columns> collect_columns(const Dataset& dataset, const std::vector<Term>& terms,
                                const std::vector<double>& ordinals, EffectColumns& worked_out) {
  Columns columns;
  auto& variables = columns.variables;
  std::map<std::string, int> index_of;
  for (const auto& term : terms) {
    std::map<int, int> exponents;
    for (const auto& factor : term.factors) {
      effects::Factor single = factor;
      int exponent = 1;
      if (auto* power = std::get_if<effects::Power>(&single)) {
        exponent = power->exponent;
        power->exponent = 1;
      }
      const std::string name = effects::notation(single);
      auto known = index_of.find(name);
      if (known == index_of.end()) {
        known = index_of.emplace(name, static_cast<int>(variables.named.size())).first;
        const auto ordinal = effects::datum_of(Term{{single}});
        variables.indicator.push_back(ordinal.has_value() ? 1 : 0);
        variables.named.push_back({name, 0, 0, 0, 1});
        if (ordinal) {
          variables.storage.push_back(datum_column(ordinals, *ordinal));
          variables.values.emplace_back(variables.storage.back());
        } else if (const auto* call = std::get_if<effects::Call>(&single)) {
          if (!worked_out.contains(name)) {
            DRIFTWISE_TRY(auto column, effect_column(dataset, *call, name));
            worked_out.emplace(name, std::move(column));
          }
          variables.storage.push_back(std::move(worked_out.extract(name).mapped()));
          variables.stored_effects.push_back(name);
          variables.values.emplace_back(variables.storage.back());
        } else {
          DRIFTWISE_TRY(auto values,
                        channel_values(dataset, name, "term " + effects::notation(term)));
          variables.values.push_back(values);
        }
      }
      exponents[known->second] += exponent;
    }
    columns.monomials.emplace_back(exponents.begin(), exponents.end());
  }
  return columns;
}

enum class RowState { complete, missing };

Result<RowState> row_state(
    const Dataset& dataset, const std::vector<RunId>& runs,
    const std::vector<std::pair<std::string, std::span<const double>>>& needed, std::size_t row) {
  RowState state = RowState::complete;
  for (const auto& [name, values] : needed) {
    if (std::isnan(values[row])) state = RowState::missing;
    if (std::isinf(values[row]))
      return fail(ErrorCode::invalid_argument, reasons::kBadValue,
                  row_text(dataset, runs, row) + ": " + name +
                      " is infinite; expected a number, or an empty field");
  }
  return state;
}

constexpr std::size_t kChunkRows = 8192;

// 1: every needed value of the row is finite, so that nobody need look at it again.
std::vector<std::uint8_t> clean_rows(
    const Dataset& dataset,
    const std::vector<std::pair<std::string, std::span<const double>>>& needed,
    const Executor& executor) {
  std::vector<std::uint8_t> clean(dataset.rows);
  run_on(executor, (dataset.rows + kChunkRows - 1) / kChunkRows, [&](std::size_t chunk) {
    const std::size_t begin = chunk * kChunkRows,
                      count = std::min(kChunkRows, dataset.rows - begin);
    // v - v is 0 for a finite v and else NaN.
    Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(static_cast<Eigen::Index>(count));
    for (const auto& [name, values] : needed) {
      const Eigen::Map<const Eigen::ArrayXd> some(values.data() + begin, sum.size());
      sum += some - some;
    }
    for (std::size_t i = 0; i < count; ++i)
      clean[begin + i] = sum[static_cast<Eigen::Index>(i)] == 0 ? 1 : 0;
  });
  return clean;
}

void find_ranges(Design& design, const std::vector<std::span<const double>>& values,
                 const Executor& executor) {
  const auto& rows = design.rows;
  if (rows.empty()) return;
  const bool together = rows.back() - rows.front() + 1 == rows.size();
  run_on(executor, design.variables.size(), [&](std::size_t v) {
    auto& variable = design.variables[v];
    if (together) {
      const Eigen::Map<const Eigen::VectorXd> all(values[v].data() + rows.front(),
                                                  design.row_count());
      variable.min = all.minCoeff();
      variable.max = all.maxCoeff();
      return;
    }
    double min = values[v][rows.front()], max = min;
    for (const std::size_t row : rows) {
      min = std::min(min, values[v][row]);
      max = std::max(max, values[v][row]);
    }
    variable.min = min;
    variable.max = max;
  });
}

// Rows from all over, at most this many, whose means stand for those of all rows.
constexpr std::size_t kMeanRows = 4096;

std::vector<std::size_t> spread_rows(const std::vector<std::size_t>& rows, std::size_t most) {
  if (rows.size() <= most) return rows;
  std::vector<std::size_t> some(most);
  for (std::size_t i = 0; i < most; ++i) some[i] = rows[rows.size() * i / most];
  return some;
}

// The weights with mean 1 over the rows: only their ratios mean something. A common factor, as the
// unit of a variance is, would otherwise stand in every residual error that the model states.
std::vector<double> about_one(std::span<const double> weights, std::span<const std::size_t> rows) {
  double largest = 0, sum = 0;
  for (const auto row : rows) largest = std::max(largest, weights[row]);
  for (const auto row : rows) sum += weights[row] / largest;
  std::vector<double> out(weights.begin(), weights.end());
  if (!rows.empty())
    for (auto& weight : out) weight = weight / largest / sum * static_cast<double>(rows.size());
  return out;
}

}  // namespace

Eigen::MatrixXd Design::block(Eigen::Index begin, Eigen::Index count) const {
  Eigen::MatrixXd out(count, width());
  fill(begin, out);
  return out;
}

void Design::fill(Eigen::Index begin, Eigen::Ref<Eigen::MatrixXd> out) const {
  columns.fill(std::span(rows).subspan(static_cast<std::size_t>(begin),
                                       static_cast<std::size_t>(out.rows())),
               out);
}

std::vector<double> datum_ordinals(const Dataset& dataset) {
  std::vector<double> ordinals(dataset.rows, 1.0);
  std::map<std::pair<std::int64_t, std::int64_t>, double> seen;
  if (dataset.run.empty() && dataset.datum.empty()) return ordinals;
  std::pair<std::int64_t, std::int64_t> last;
  for (std::size_t row = 0; row < dataset.rows; ++row) {
    const std::pair<std::int64_t, std::int64_t> id = {
        dataset.run.empty() ? 0 : dataset.run[row], dataset.datum.empty() ? 0 : dataset.datum[row]};
    ordinals[row] = row > 0 && id == last
                        ? ordinals[row - 1]
                        : seen.try_emplace(id, static_cast<double>(seen.size()) + 1).first->second;
    last = id;
  }
  return ordinals;
}

Result<Design> make_design(const Dataset& dataset, const FitOptions& options) {
  Design design;
  design.constant = options.candidates.constant;
  const std::vector<double> ordinals = datum_ordinals(dataset);
  const std::size_t end =
      options.first_rows > 0
          ? end_of_first_rows(dataset, static_cast<std::size_t>(options.first_rows))
          : dataset.rows;
  const auto calibrates = [&](std::size_t row) {
    return dataset.set_of(row) == PointSet::calibration && !dataset.is_excluded(row) && row < end;
  };
  std::vector<std::span<const double>> outputs;
  std::vector<std::pair<std::string, std::span<const double>>> needed;
  for (const auto& symbol : options.candidates.outputs) {
    DRIFTWISE_TRY(auto values, channel_values(dataset, symbol, "the left side"));
    design.outputs.push_back(dataset.find(symbol)->channel);
    outputs.push_back(values);
    needed.emplace_back(symbol, values);
  }
  if (outputs.empty())
    return fail(ErrorCode::invalid_argument, reasons::kNoOutput,
                "nothing stands on the left of the formula");
  std::span<const double> weights;
  if (!options.weight_symbol.empty()) {
    DRIFTWISE_TRY(auto values, channel_values(dataset, options.weight_symbol, "the weights"));
    weights = values;
    design.weighted = true;
    needed.emplace_back(options.weight_symbol, weights);
  }

  for (const auto& symbol : options.exclude_channels)
    DRIFTWISE_RETURN_IF_ERROR(channel_values(dataset, symbol, "the list of channels to leave out"));
  // The formula refuses it for its own terms; a term that is forced comes beside the formula.
  for (const auto& term : options.forced)
    for (const auto& symbol : effects::symbols_read_at_once(term))
      if (std::ranges::find(options.candidates.outputs, symbol) != options.candidates.outputs.end())
        return fail(ErrorCode::invalid_argument, reasons::kBadOptions,
                    "the output " + symbol + " stands among its own terms, in the forced term " +
                        effects::notation(term) + ": it would explain itself");
  // Which rows are complete, before the datums: one without a complete row has no constant, and is
  // not the one that the others count from.
  EffectColumns worked_out;
  DRIFTWISE_TRY(auto undated,
                collect_columns(dataset, offered_terms(options, {}).terms, ordinals, worked_out));
  for (std::size_t v = 0; v < undated.variables.named.size(); ++v)
    needed.emplace_back(undated.variables.named[v].name, undated.variables.values[v]);

  const auto clean = clean_rows(dataset, needed, options.executor);
  design.rows.reserve(dataset.rows);
  design.datum.reserve(dataset.rows);
  for (std::size_t row = 0; row < dataset.rows; ++row) {
    if (dataset.is_excluded(row)) {
      if (!is_passage(dataset, row)) ++design.excluded;
      continue;
    }
    const bool calibration = calibrates(row);
    if (!calibration && dataset.set_of(row) == PointSet::calibration)
      continue;  // beyond first_rows
    RowState state = RowState::complete;
    if (clean[row] == 0) {
      DRIFTWISE_TRY(const auto seen, row_state(dataset, options.lineage.runs, needed, row));
      state = seen;
    }
    if (!weights.empty() && weights[row] < 0)
      return fail(ErrorCode::invalid_argument, reasons::kBadValue,
                  row_text(dataset, options.lineage.runs, row) + ": weight " +
                      options.weight_symbol + " is " + effects::number_text(weights[row]) +
                      "; expected 0 or more");
    if (state == RowState::missing) {
      ++design.dropped;
    } else if (!calibration) {
      ++design.validation;
    } else if (weights.empty() || weights[row] > 0) {
      design.rows.push_back(row);
      design.datum.push_back(static_cast<int>(ordinals[row]));
    }
  }

  std::vector<int> datums = design.datum;
  std::ranges::sort(datums);
  datums.erase(std::unique(datums.begin(), datums.end()), datums.end());
  OfferedTerms offered = offered_terms(options, datums);
  design.terms = std::move(offered.terms);
  design.always = std::move(offered.always);
  for (std::size_t i = 0; i < undated.variables.storage.size(); ++i)
    worked_out.emplace(undated.variables.stored_effects[i],
                       std::move(undated.variables.storage[i]));
  DRIFTWISE_TRY(auto columns, collect_columns(dataset, design.terms, ordinals, worked_out));
  auto& variables = columns.variables;
  design.variables = std::move(variables.named);
  find_ranges(design, variables.values, options.executor);
  for (std::size_t v = 0; v < design.variables.size(); ++v)
    centre(design.variables[v], variables.indicator[v] != 0);
  DRIFTWISE_TRY(auto basis, make_basis(design.variables, columns.monomials));
  design.basis = std::move(basis);
  if (!weights.empty()) {
    variables.storage.push_back(about_one(weights, design.rows));
    weights = variables.storage.back();
  }
  design.columns = DesignColumns(
      {std::move(variables.values), std::move(outputs), weights, std::move(variables.storage)},
      design.variables, design.basis);
  design.columns.take_off_means_of(spread_rows(design.rows, kMeanRows));
  return design;
}

}  // namespace driftwise::calibration
