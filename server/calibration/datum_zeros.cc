#include "server/calibration/datum_zeros.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <set>
#include <string_view>

#include "server/calibration/design/design.h"
#include "server/calibration/design/predict.h"
#include "server/calibration/linear/row_reduction.h"
#include "server/calibration/pose_of_zero.h"
#include "server/calibration/report/enough_rows.h"
#include "server/calibration/selection/selected.h"
#include "server/calibration/selection/selection_rule.h"
#include "server/effects/term_order.h"

namespace driftwise::calibration {
namespace {

using Eigen::Index;

constexpr int kTurns = 8;
constexpr double kStep = 1e-3;           // of an axis' range, for slopes
constexpr double kSettled = 1e-9;        // of it: the last step of a zero that stays
constexpr double kSettledEnough = 1e-5;  // ... where the selection goes back and forth
constexpr double kFollows = 1e-3;        // smallest pivot of the slopes by the largest
constexpr double kClearly = 10;  // of n ln RSS: rows that fit so much better with the constant
constexpr double kDoubtful = 1;  // of a datum's sum of squares: rounding is nothing to ask about
constexpr int kRounds = 8;       // of asking; two fits in each, and those that settle what changed

// One fit of the rows as they are moved now.
struct Pass {
  std::vector<OutputModel> outputs;  // terms and coefficients only
  std::vector<std::size_t> rows;     // of the fit
  std::vector<int> datum;            // of each
  Eigen::VectorXd rss;               // per output
};

std::optional<Pass> fit_once(const Dataset& dataset, const FitOptions& options) {
  auto design = make_design(dataset, options);
  if (!design) return std::nullopt;
  const auto rule = selection_rule(options, *design);
  if (!rule || !check_enough_rows(dataset, *design, options)) return std::nullopt;
  const RowReduction whole(*design, {0, design->row_count()}, options.solver, options.executor);
  const auto fitted = select_and_solve(*design, whole.all(), *rule, options.executor);
  if (!fitted) return std::nullopt;
  Pass pass;
  pass.rss.resize(static_cast<Index>(fitted->size()));
  for (std::size_t o = 0; o < fitted->size(); ++o) {
    const Solution& solution = (*fitted)[o].solution;
    OutputModel output;
    output.channel = design->outputs[o];
    for (const int column : solution.columns)
      output.terms.push_back(design->terms[static_cast<std::size_t>(column)]);
    output.coefficients = solution.coefficients;
    pass.outputs.push_back(std::move(output));
    pass.rss[static_cast<Index>(o)] = solution.rss;
  }
  pass.rows = std::move(design->rows);
  pass.datum = std::move(design->datum);
  return pass;
}

double misfit(const Pass& pass) {
  return static_cast<double>(pass.rows.size()) * pass.rss.array().max(1e-300).log().sum();
}

struct Axis {
  std::size_t column = 0;  // of the dataset
  std::string channel;
  double range = 0;  // over the rows of the fit
};

std::string away_text(const Axis& axis, double by) {
  char text[96];
  std::snprintf(text, sizeof text, "%s = %.4g, more than 2 %% of the range fitted",
                axis.channel.c_str(), by);
  return text;
}

class ZeroSearch {
 public:
  ZeroSearch(const Dataset& dataset, const FitOptions& options)
      : measured_(dataset),
        options_(options),
        moved_(dataset),
        ordinals_(datum_ordinals(dataset)) {}

  std::vector<DatumZero> find() {
    auto first = fit_once(measured_, options_);
    if (!first) return {};
    for (const auto& term : first->outputs.front().terms)
      if (const auto ordinal = effects::datum_of(term)) known_.push_back({*ordinal, {}, {}, {}});
    std::ranges::sort(known_, {}, &Known::ordinal);
    if (known_.empty()) return {};
    if (auto why = find_axes(*first); !why.empty()) {
      for (auto& one : known_) one.why_not = why;
    } else {
      find_slopes(*first);
      if (auto last = settle(*first)) keep_what_the_rows_bear_out(*first, std::move(*last));
    }
    return zeros();
  }

 private:
  struct Known {
    int ordinal = 0;
    Eigen::VectorXd at;      // per axis
    Eigen::MatrixXd slopes;  // outputs x axes
    std::string why_not;
    bool moves() const { return why_not.empty(); }
  };

  std::string find_axes(const Pass& pass) {
    std::vector<std::string> symbols;
    std::set<std::string_view> robots;  // whose motor coordinates are fitted
    for (const auto& output : pass.outputs) {
      const std::string& motor = output.channel.symbol;
      if (!is_motor_symbol(without_robot(motor)) || !is_length(output.channel.unit))
        return output.channel.name() + " is no motor coordinate";
      robots.insert(robot_of(motor));
      for (const auto& term : output.terms)
        for (const auto& symbol : effects::symbols_of(term))
          if (std::ranges::find(symbols, symbol) == symbols.end()) symbols.push_back(symbol);
    }
    for (std::size_t c = 0; c < measured_.columns.size(); ++c) {
      const auto& [channel, values] = measured_.columns[c];
      if (!is_pose_symbol(without_robot(channel.symbol)) || !is_length(channel.unit) ||
          !robots.contains(robot_of(channel.symbol)) ||
          std::ranges::find(symbols, channel.symbol) == symbols.end())
        continue;
      double low = HUGE_VAL, high = -HUGE_VAL;
      for (const std::size_t row : pass.rows) {
        low = std::min(low, values[row]);
        high = std::max(high, values[row]);
      }
      axes_.push_back({c, channel.name(), high - low});
      if (!(high > low)) return channel.name() + " does not vary";
    }
    if (axes_.size() != pass.outputs.size())
      return "motor coordinates fitted: " + std::to_string(pass.outputs.size()) +
             ", axes in their terms: " + std::to_string(axes_.size());
    for (auto& one : known_) one.at = Eigen::VectorXd::Zero(static_cast<Index>(axes_.size()));
    return {};
  }

  void find_slopes(const Pass& pass) {
    const auto count = static_cast<Index>(axes_.size());
    for (auto& one : known_) one.slopes.resize(count, count);
    for (Index a = 0; a < count; ++a) {
      const Axis& axis = axes_[static_cast<std::size_t>(a)];
      const double step = kStep * axis.range;
      const auto beside = [&](double by) {
        Dataset aside = measured_;
        for (double& value : aside.columns[axis.column].values) value += by;
        std::vector<Eigen::VectorXd> predicted;
        for (const auto& output : pass.outputs)
          predicted.push_back(predict(aside, output, options_.executor)
                                  .value_or(Eigen::VectorXd::Zero(static_cast<Index>(aside.rows))));
        return predicted;
      };
      const auto below = beside(-step), above = beside(step);
      for (auto& one : known_)
        for (Index o = 0; o < count; ++o) {
          double sum = 0, rows = 0;
          for (std::size_t i = 0; i < pass.rows.size(); ++i) {
            if (pass.datum[i] != one.ordinal) continue;
            const auto row = static_cast<Index>(pass.rows[i]);
            sum +=
                above[static_cast<std::size_t>(o)][row] - below[static_cast<std::size_t>(o)][row];
            ++rows;
          }
          one.slopes(o, a) = sum / rows / (2 * step);
        }
    }
    for (auto& one : known_) {
      const Eigen::FullPivLU<Eigen::MatrixXd> lu(one.slopes);
      const Eigen::VectorXd pivots = lu.matrixLU().diagonal().cwiseAbs();
      if (!one.slopes.allFinite() || !(pivots.minCoeff() > kFollows * pivots.maxCoeff()))
        one.why_not = "the motor coordinates do not follow every axis";
    }
  }

  // The constants of one datum in a pass; none where an output has none.
  std::optional<Eigen::VectorXd> constants_of(const Pass& pass, int ordinal) const {
    Eigen::VectorXd constants(static_cast<Index>(pass.outputs.size()));
    for (std::size_t o = 0; o < pass.outputs.size(); ++o) {
      const auto& terms = pass.outputs[o].terms;
      const auto at = std::ranges::find_if(
          terms, [&](const effects::Term& term) { return effects::datum_of(term) == ordinal; });
      if (at == terms.end()) return std::nullopt;
      constants[static_cast<Index>(o)] = pass.outputs[o].coefficients[at - terms.begin()];
    }
    return constants;
  }

  void place(const Known& one) {
    for (std::size_t a = 0; a < axes_.size(); ++a) {
      const double by = one.moves() ? one.at[static_cast<Index>(a)] : 0;
      auto& to = moved_.columns[axes_[a].column].values;
      const auto& from = measured_.columns[axes_[a].column].values;
      for (std::size_t row = 0; row < to.size(); ++row)
        if (static_cast<int>(ordinals_[row]) == one.ordinal) to[row] = from[row] + by;
    }
  }

  // The last pass, in which the constants of what moves are gone. None: nothing moves.
  std::optional<Pass> settle(const Pass& first) {
    std::optional<Pass> pass = first;
    for (int turn = 0;; ++turn) {
      double largest = 0;  // step of the ranges
      for (auto& one : known_) {
        if (!one.moves()) continue;
        largest = std::max(largest, step(*pass, one, turn == kTurns));
        place(one);
      }
      if (std::ranges::none_of(known_, &Known::moves)) return std::nullopt;
      if (largest < kSettled || turn == kTurns) return pass;
      pass = fit_once(moved_, options_);
      if (!pass) {
        for (auto& one : known_) one.why_not = "the rows moved there cannot be fitted";
        return std::nullopt;
      }
    }
  }

  // Moves one datum's zero by what its constants say; the step, as a part of the ranges.
  double step(const Pass& pass, Known& one, bool last) {
    const auto constants = constants_of(pass, one.ordinal);
    if (!constants) {
      one.why_not = "its rows do not tell a constant of their own";
      return 0;
    }
    const Eigen::VectorXd by = one.slopes.fullPivLu().solve(*constants);
    double largest = 0;
    for (std::size_t a = 0; a < axes_.size(); ++a)
      largest = std::max(largest, std::abs(by[static_cast<Index>(a)]) / axes_[a].range);
    if (last) {
      if (!(largest < kSettledEnough)) one.why_not = "its zero does not settle";
      return largest;
    }
    one.at += by;
    for (std::size_t a = 0; a < axes_.size() && one.moves(); ++a)
      if (!(std::abs(one.at[static_cast<Index>(a)]) < kFarthestZero * axes_[a].range))
        one.why_not = "its zero would lie at " + away_text(axes_[a], one.at[static_cast<Index>(a)]);
    return largest;
  }

  // What the rows of each datum of known_ leave of a pass, every output in its own spread.
  std::vector<double> left_by_datum(const Pass& pass, const Dataset& data,
                                    const Eigen::VectorXd& variance) const {
    std::map<int, double> left;
    for (std::size_t o = 0; o < pass.outputs.size(); ++o) {
      const auto predicted = predict(data, pass.outputs[o], options_.executor);
      if (!predicted) return std::vector<double>(known_.size(), 0);
      const auto& q = measured_.find(pass.outputs[o].channel.symbol)->values;
      for (std::size_t i = 0; i < pass.rows.size(); ++i)
        left[pass.datum[i]] +=
            std::pow(q[pass.rows[i]] - (*predicted)[static_cast<Index>(pass.rows[i])], 2) /
            variance[static_cast<Index>(o)];
    }
    std::vector<double> out;
    for (const auto& one : known_) out.push_back(left[one.ordinal]);
    return out;
  }

  // Datums whose rows were better off unmoved are tried without, the worst together and then the
  // worst alone: one that does not belong where it was moved bends the fit for the others too. All
  // are judged from one pass, so that many datums cost as many fits as few.
  void keep_what_the_rows_bear_out(const Pass& first, Pass last) {
    std::set<int> tried;
    for (int round = 0; round < kRounds; ++round) {
      const Eigen::VectorXd variance =
          (last.rss.array().max(1e-300) / static_cast<double>(last.rows.size())).matrix();
      const auto moved = left_by_datum(last, moved_, variance),
                 unmoved = left_by_datum(first, measured_, variance);
      std::vector<std::pair<double, Known*>> doubtful;
      for (std::size_t i = 0; i < known_.size(); ++i)
        if (known_[i].moves() && moved[i] - unmoved[i] > kDoubtful &&
            !tried.contains(known_[i].ordinal))
          doubtful.emplace_back(moved[i] - unmoved[i], &known_[i]);
      if (doubtful.empty()) return;
      std::ranges::stable_sort(doubtful, std::greater{}, &std::pair<double, Known*>::first);
      std::vector<Known*> worst;
      for (const auto& [loss, one] : doubtful)
        if (loss >= doubtful.front().first / 2) worst.push_back(one);
      if (fits_better_without(worst, last)) continue;
      if (worst.size() > 1 && fits_better_without({worst.front()}, last)) continue;
      tried.insert(worst.front()->ordinal);
    }
  }

  // Leaves these datums unmoved where the rows clearly fit better so; last: the pass then.
  bool fits_better_without(const std::vector<Known*>& datums, Pass& last) {
    for (Known* one : datums) {
      one->why_not =
          "its rows fit better where they were measured: its scales were homed elsewhere";
      place(*one);
    }
    auto without = fit_once(moved_, options_);
    if (without &&
        misfit(*without) < misfit(last) - kClearly * static_cast<double>(datums.size())) {
      auto again = settle(*without);
      last = again ? std::move(*again) : std::move(*without);
      return true;
    }
    for (Known* one : datums) {
      one->why_not.clear();
      place(*one);
    }
    return false;
  }

  std::vector<DatumZero> zeros() const {
    std::vector<DatumZero> out;
    for (const auto& one : known_) {
      DatumZero& zero = out.emplace_back(DatumZero{one.ordinal, {}, one.why_not});
      for (std::size_t a = 0; a < axes_.size() && one.moves(); ++a)
        zero.pose.push_back({axes_[a].channel, one.at[static_cast<Index>(a)]});
    }
    return out;
  }

  const Dataset& measured_;
  const FitOptions& options_;
  Dataset moved_;
  std::vector<double> ordinals_;
  std::vector<Known> known_;
  std::vector<Axis> axes_;
};

}  // namespace

std::vector<DatumZero> find_datum_zeros(const Dataset& dataset, const FitOptions& options) {
  if (!options.move_datums || !options.candidates.constant) return {};
  const auto differs = [](const std::vector<std::int64_t>& ids) {
    return std::ranges::adjacent_find(ids, std::not_equal_to{}) != ids.end();
  };
  if (!differs(dataset.run) && !differs(dataset.datum)) return {};
  return ZeroSearch(dataset, options).find();
}

bool any_moved(const std::vector<DatumZero>& zeros) {
  return std::ranges::any_of(zeros, [](const DatumZero& zero) { return !zero.pose.empty(); });
}

Dataset in_first_datum(Dataset dataset, const std::vector<DatumZero>& zeros) {
  if (!any_moved(zeros)) return dataset;
  const auto ordinals = datum_ordinals(dataset);
  for (const auto& zero : zeros)
    for (const auto& [channel, by] : zero.pose)
      for (auto& column : dataset.columns)
        if (column.channel.name() == channel)
          for (std::size_t row = 0; row < dataset.rows; ++row)
            if (static_cast<int>(ordinals[row]) == zero.ordinal) column.values[row] += by;
  return dataset;
}

}  // namespace driftwise::calibration
