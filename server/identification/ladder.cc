#include "server/identification/ladder.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "server/calibration/report/held_out_figure.h"
#include "server/core/data/dataset_parts.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/effects/term_order.h"
#include "server/identification/bench.h"
#include "server/identification/pose_rows.h"

namespace driftwise::identification {
namespace {

using effects::Power;
using effects::Term;

constexpr const char* kTemperatures = "temperatures";
constexpr const char* kForce = "force";

std::string listed(const std::vector<std::string>& symbols, const char* between) {
  std::string text;
  for (const auto& symbol : symbols) text += (text.empty() ? "" : between) + symbol;
  return text;
}

std::string geometry_name(int order) { return "geometry of order " + std::to_string(order); }

// All monomials of exactly this degree.
void add_monomials(const std::vector<std::string>& symbols, std::size_t from, int left,
                   const Term& begun, std::vector<Term>& terms) {
  if (left == 0) {
    terms.push_back(effects::canonical(begun));
    return;
  }
  for (std::size_t i = from; i < symbols.size(); ++i)
    add_monomials(symbols, i, left - 1, effects::product(begun, {{Power{symbols[i], 1}}}), terms);
}

std::vector<Term> monomials(const std::vector<std::string>& symbols, int lowest, int highest) {
  std::vector<Term> terms;
  for (int degree = lowest; degree <= highest; ++degree)
    add_monomials(symbols, 0, degree, {}, terms);
  return terms;
}

// Range of a channel, in its unit, that is more than what its instrument reads at rest.
double least_range(const std::string& unit) {
  const double in_unit = 1 / summary_unit(unit).factor;
  if (is_length(unit)) return in_unit;  // 1 nm
  if (is_angle(unit)) return in_unit;   // 1 arcsec
  return unit == "degC" || unit == "K" ? 0.01 : 1e-4;
}

bool varies(const Dataset& dataset, const DatasetColumn& column) {
  double low = INFINITY, high = -INFINITY;
  for (const std::size_t row : rows_in(dataset, PointSet::calibration)) {
    const double value = column.values[row];
    if (!std::isfinite(value)) continue;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  return high - low > least_range(column.channel.unit);
}

struct Inputs {
  std::vector<std::string> position, temperatures, forces;
  std::vector<std::string> constant;  // what would be one of them if it varied
};

Inputs inputs_of(const Dataset& dataset, const std::vector<std::string>& outputs) {
  const Parts parts = parts_from(dataset.metadata);
  const auto on_robot = [&](const std::string& symbol) {
    std::string part;
    for (const auto& [name, where] : parts)
      if (name == symbol) part = where;
    return parts.empty() || part == "robot";
  };
  // Of data of several robots: the position of the one that the outputs are of.
  const auto robot = outputs.empty() ? std::string_view() : robot_of(outputs.front());
  const auto is_its = [&](const std::string& symbol, auto is_kind) {
    return robot_of(symbol) == robot && is_kind(without_robot(symbol));
  };
  const auto is_motor = [](std::string_view symbol) { return is_motor_symbol(symbol); };
  const auto is_pose = [](std::string_view symbol) { return is_pose_symbol(symbol); };
  const bool pose_is_asked = std::ranges::any_of(
      outputs, [&](const std::string& output) { return is_its(output, is_pose); });
  // Large rotations are positions of a robot that turns; parasitic ones follow from its position.
  bool turns = false;
  Inputs inputs;
  std::vector<std::string> rotations;
  for (const auto& column : dataset.columns) {
    const auto& channel = column.channel;
    if (std::ranges::find(outputs, channel.symbol) != outputs.end()) continue;
    std::vector<std::string>* kind = nullptr;
    if (is_structure_temperature(channel)) {
      if (on_robot(channel.symbol)) kind = &inputs.temperatures;
    } else if (channel.unit == "N") {
      kind = &inputs.forces;
    } else if (pose_is_asked ? is_its(channel.symbol, is_motor) : is_its(channel.symbol, is_pose)) {
      kind = is_angle(channel.unit) ? &rotations : &inputs.position;
    }
    if (kind != nullptr)
      (varies(dataset, column) ? *kind : inputs.constant).push_back(channel.symbol);
  }
  turns = inputs.position.size() < outputs.size();
  if (turns) inputs.position.insert(inputs.position.begin(), rotations.begin(), rotations.end());
  return inputs;
}

std::vector<Term> crossed(const std::vector<std::string>& symbols, const std::vector<Term>& terms) {
  std::vector<Term> products;
  for (const auto& symbol : symbols)
    for (const auto& term : terms) products.push_back(effects::product({{Power{symbol, 1}}}, term));
  return products;
}

}  // namespace

std::vector<Rung> rungs_of(const Dataset& dataset, const std::vector<std::string>& outputs,
                           int most_order) {
  const Inputs in = inputs_of(dataset, outputs);
  std::vector<Rung> rungs;
  const std::string position = listed(in.position, ", ");
  if (!in.position.empty())
    for (int order = 1; order <= most_order; ++order) {
      // Orders may be jumped over: a robot that is symmetric has no even ones.
      std::vector<std::string> needs;
      if (order > 1) needs.push_back(geometry_name(1));
      rungs.push_back({geometry_name(order),
                       "poly(" + position + ", " + std::to_string(order) + ")",
                       monomials(in.position, 1, order), needs});
    }
  if (!in.temperatures.empty())
    rungs.push_back(
        {kTemperatures, listed(in.temperatures, " + "), monomials(in.temperatures, 1, 1), {}});
  if (!in.forces.empty()) {
    std::vector<Term> powers;
    std::string text;
    for (const auto& force : in.forces)
      for (int power = 1; power <= 3; ++power) {
        powers.push_back({{Power{force, power}}});
        text += (text.empty() ? "" : " + ") + effects::notation(powers.back());
      }
    rungs.push_back({kForce, text, powers, {}});
  }
  if (!in.position.empty())
    for (int order = 1; order <= 2; ++order) {
      const auto products = monomials(in.position, 1, order);
      const std::string by = ":poly(" + position + ", " + std::to_string(order) + ")";
      const std::string of_order = " x position of order " + std::to_string(order);
      if (!in.forces.empty())
        rungs.push_back({kForce + of_order,
                         "(" + listed(in.forces, " + ") + ")" + by,
                         crossed(in.forces, products),
                         {geometry_name(1)}});
      if (!in.temperatures.empty())
        rungs.push_back({kTemperatures + of_order,
                         "(" + listed(in.temperatures, " + ") + ")" + by,
                         crossed(in.temperatures, products),
                         {geometry_name(1)}});
    }
  return rungs;
}

namespace {

struct Climber {
  const Dataset& dataset;
  const LadderOptions& options;
  std::vector<Fold> folds;
  std::vector<Rung> rungs;

  struct State {
    std::vector<const Rung*> in{};
    std::size_t offered = 0;             // terms
    std::vector<double> fold_squares{};  // mean square over the outputs, per fold
    LadderStep step{};
  };

  static bool is_in(const State& state, const std::string& name) {
    return std::ranges::any_of(state.in, [&](const Rung* rung) { return rung->name == name; });
  }

  // A rung of a higher order replaces those of the same kind below it.
  std::string formula_of(const State& state) const {
    std::string left = listed(options.fit.candidates.outputs, " + "), right;
    std::map<std::string, const Rung*> last;  // by kind: the name without its order
    std::vector<std::string> kinds;
    for (const Rung* rung : state.in) {
      const std::string kind = rung->name.substr(0, rung->name.find(" order "));
      if (!last.contains(kind)) kinds.push_back(kind);
      last[kind] = rung;
    }
    for (const auto& kind : kinds) right += (right.empty() ? "" : " + ") + last[kind]->formula;
    return left + " ~ " + (right.empty() ? "1" : right);
  }

  calibration::FitOptions fit_of(const State& state) const {
    calibration::FitOptions fit = options.fit;
    fit.blocks = 0;
    fit.stopwatch_us = {};
    fit.candidates.terms.clear();
    std::set<std::string> known;
    for (const Rung* rung : state.in)
      for (const auto& term : rung->terms)
        if (known.insert(effects::notation(term)).second) fit.candidates.terms.push_back(term);
    fit.candidates.formula = formula_of(state);
    return fit;
  }

  Result<State> tried(const State& before, const Rung* rung) const {
    State state;
    state.in = before.in;
    if (rung != nullptr) state.in.push_back(rung);
    MethodOptions method{.fit = fit_of(state), .mechanism = nullptr};
    state.offered = method.fit.candidates.terms.size();
    DRIFTWISE_TRY(const auto model, calibration::fit(dataset, method.fit));
    method.fit.executor = options.fit.executor;
    std::vector<Channel> outputs;
    for (const auto& output : model.outputs) outputs.push_back(output.channel);
    DRIFTWISE_TRY(auto measured, measured_outputs(dataset, outputs));
    const Bench bench{dataset, Method::stepwise, method, std::move(measured)};
    std::vector<std::string> warnings;
    const FoldErrors errors = bench.errors_of(folds, "of the ladder", warnings);
    if (errors.empty())
      return fail(ErrorCode::failed_precondition, reasons::kTooFewRows, warnings.front());
    state.step.formula = method.fit.candidates.formula;
    state.step.added = rung != nullptr ? rung->name : "the constant";
    double squares = 0, terms = 0;
    state.fold_squares.assign(errors.size(), 0);
    for (std::size_t o = 0; o < model.outputs.size(); ++o) {
      std::vector<ErrorSums> sums(errors.size());
      for (std::size_t f = 0; f < errors.size(); ++f) {
        for (const double error : errors[f][o]) sums[f].add(error);
        state.fold_squares[f] += sums[f].squares;
      }
      const auto figure = calibration::held_out_figure(sums);
      const auto& output = model.outputs[o];
      state.step.outputs.push_back({output.channel, figure.figures.a90, figure.low, figure.high,
                                    output.accuracy.a90_validation});
      squares += figure.figures.a90 * figure.figures.a90;
      terms += static_cast<double>(output.terms.size());
    }
    const auto count = static_cast<double>(model.outputs.size());
    state.step.a90_rms = std::sqrt(squares / count);
    state.step.terms = static_cast<int>(std::lround(terms / count));
    compare(before, state);
    return state;
  }

  // Jackknife over the folds of the logarithm of the ratio of both mean squares: what is hard in a
  // fold is hard for both.
  void compare(const State& before, State& after) const {
    if (before.fold_squares.empty()) return;
    const auto ratio_without = [&](std::size_t left_out) {
      double old = 0, young = 0;
      for (std::size_t f = 0; f < folds.size(); ++f)
        if (f != left_out) old += before.fold_squares[f], young += after.fold_squares[f];
      return 0.5 * std::log(young / old);
    };
    const auto count = static_cast<double>(folds.size());
    const double whole = ratio_without(folds.size());
    double mean = 0, squares = 0;
    std::vector<double> parts;
    for (std::size_t f = 0; f < folds.size(); ++f)
      mean += (parts.emplace_back(ratio_without(f))) / count;
    for (const double part : parts) squares += (part - mean) * (part - mean);
    after.step.gain = 1 - std::exp(whole);
    after.step.gain_u = std::exp(whole) * std::sqrt((count - 1) / count * squares);
  }

  bool allowed(const State& state, const Rung& rung) const {
    if (is_in(state, rung.name)) return false;
    for (const auto& need : rung.needs)
      if (!is_in(state, need)) return false;
    // A lower order than one that is in adds nothing.
    const auto at = rung.name.find(" order ");
    if (at == std::string::npos) return true;
    for (const Rung* in : state.in)
      if (in->name.starts_with(rung.name.substr(0, at + 7)) && in->name > rung.name) return false;
    return true;
  }

  bool helps(const LadderStep& step) const {
    return step.gain > options.least_gain && step.gain > step.gain_u;
  }
};

// Of those that gain as much as the best within its uncertainty, the one that offers fewest terms.
Climber::State* simplest_of_the_best(std::vector<Climber::State>& helping) {
  Climber::State* best = nullptr;
  for (auto& one : helping)
    if (best == nullptr || one.step.gain > best->step.gain) best = &one;
  if (best == nullptr) return nullptr;
  const double enough = best->step.gain - best->step.gain_u;
  for (auto& one : helping)
    if (one.step.gain >= enough && one.offered < best->offered) best = &one;
  return best;
}

Result<std::vector<Fold>> folds_for(const Dataset& dataset, const LadderOptions& options,
                                    std::string& words) {
  const auto rows = rows_in(dataset, PointSet::calibration);
  std::vector<Fold> folds;
  if (options.together.empty()) {
    folds = time_folds(rows, options.folds, options.gap);
    words = std::to_string(options.folds) + " blocks of time";
  } else {
    DRIFTWISE_TRY(const auto labels, group_labels(dataset, options.together));
    folds = group_folds(rows, labels, options.folds);
    words = std::to_string(options.folds) + " folds, rows of one " + options.together + " together";
  }
  if (folds.size() < 2)
    return fail(ErrorCode::invalid_argument, reasons::kNoBlocks,
                std::to_string(rows.size()) + " calibration rows do not make " + words +
                    ": ask for fewer folds");
  return folds;
}

Result<void> check_outputs(const Dataset& dataset, const std::vector<std::string>& outputs) {
  if (outputs.empty())
    return fail(ErrorCode::invalid_argument, reasons::kNoOutput,
                "the data have no motor coordinate q1, q2 ...: name what is to be predicted");
  std::string unit;
  for (const auto& symbol : outputs) {
    const DatasetColumn* column = dataset.find(symbol);
    if (column == nullptr)
      return fail(ErrorCode::invalid_argument, reasons::kNoOutput,
                  "the data have no channel '" + symbol.substr(0, 80) + "' to predict");
    if (!unit.empty() && column->channel.unit != unit)
      return fail(ErrorCode::invalid_argument, reasons::kUnitsDisagree,
                  "'" + symbol + "' is in " + column->channel.unit + ", another output in " + unit +
                      ": one held-out figure needs one unit; climb for each kind by itself");
    unit = column->channel.unit;
  }
  return {};
}

}  // namespace

Result<Ladder> climb(const Dataset& whole, const LadderOptions& options) {
  DRIFTWISE_RETURN_IF_ERROR(check_outputs(whole, options.fit.candidates.outputs));
  std::vector<std::string> needed = options.fit.candidates.outputs;
  auto rungs = rungs_of(whole, needed, options.most_order);
  for (const auto& rung : rungs)
    for (const auto& term : rung.terms)
      for (auto& symbol : effects::symbols_of(term)) needed.push_back(std::move(symbol));
  const Dataset dataset = without_incomplete_rows(whole, needed);
  Ladder ladder;
  if (const auto constant = inputs_of(whole, options.fit.candidates.outputs).constant;
      !constant.empty())
    ladder.notes.push_back(listed(constant, ", ") + ": taken as constant, no term of it was tried");
  ladder.rows = static_cast<std::int64_t>(rows_in(dataset, PointSet::calibration).size());
  DRIFTWISE_TRY(auto folds, folds_for(dataset, options, ladder.held_out));
  const Climber climber{dataset, options, std::move(folds), std::move(rungs)};
  DRIFTWISE_TRY(auto state, climber.tried({}, nullptr));
  ladder.steps.push_back(state.step);
  while (true) {
    ladder.refused.clear();
    std::vector<Climber::State> helping;
    for (const auto& rung : climber.rungs) {
      if (!climber.allowed(state, rung)) continue;
      auto next = climber.tried(state, &rung);
      if (!next) {
        ladder.refused.push_back({rung.name, 0, 0, 0, next.error().message});
        continue;
      }
      ladder.refused.push_back(
          {rung.name, next->step.a90_rms, next->step.gain, next->step.gain_u, ""});
      if (climber.helps(next->step)) helping.push_back(std::move(*next));
    }
    Climber::State* best = simplest_of_the_best(helping);
    if (best == nullptr) break;
    state = std::move(*best);
    ladder.steps.push_back(state.step);
  }
  if (ladder.refused.empty())
    ladder.stopped = "every group of terms that these channels allow is in";
  else
    ladder.stopped = "none of the " + std::to_string(ladder.refused.size()) +
                     " groups left lowers the held-out A90 by more than " +
                     effects::number_text(std::round(1000 * options.least_gain) / 10) +
                     " % and by more than the uncertainty of its gain";
  return ladder;
}

}  // namespace driftwise::identification
