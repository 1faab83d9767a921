#include "server/identification/learning_curve.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include "server/calibration/report/held_out_figure.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/effects/term_order.h"
#include "server/identification/bench.h"
#include "server/identification/pose_rows.h"

namespace driftwise::identification {
namespace {

std::vector<std::string> inputs_of_terms(const calibration::Candidates& candidates) {
  std::set<std::string> symbols;
  for (const auto& term : candidates.terms)
    for (const auto& symbol : effects::symbols_of(term)) symbols.insert(symbol);
  return {symbols.begin(), symbols.end()};
}

// Of several outputs in one unit; none where a fold could not be fitted.
std::optional<CurveFigure> figure_of(const std::vector<std::vector<std::vector<double>>>& errors) {
  std::vector<ErrorSums> folds;
  std::size_t outputs = 0;
  for (const auto& fold : errors) {
    if (fold.empty()) return std::nullopt;
    auto& sums = folds.emplace_back();
    outputs = fold.size();
    for (const auto& output : fold)
      for (const double error : output) sums.add(error);
  }
  if (outputs == 0) return std::nullopt;
  const auto figure = calibration::held_out_figure(folds);
  return CurveFigure{figure.figures.a90, figure.low, figure.high};
}

}  // namespace

std::vector<std::size_t> spread_order(const Dataset& dataset, const std::vector<std::size_t>& rows,
                                      const std::vector<std::string>& symbols, std::size_t count) {
  count = std::min(count, rows.size());
  if (count == 0) return {};
  Eigen::MatrixXd places(0, static_cast<Eigen::Index>(rows.size()));  // one column a row
  for (const auto& symbol : symbols) {
    const auto* column = dataset.find(symbol);
    if (column == nullptr) continue;
    double low = INFINITY, high = -INFINITY;
    for (const std::size_t row : rows) {
      low = std::min(low, column->values[row]);
      high = std::max(high, column->values[row]);
    }
    if (!(high > low)) continue;
    places.conservativeResize(places.rows() + 1, Eigen::NoChange);
    for (std::size_t i = 0; i < rows.size(); ++i)
      places(places.rows() - 1, static_cast<Eigen::Index>(i)) =
          (column->values[rows[i]] - low) / (high - low);
  }
  const auto square = [&places](std::size_t a, std::size_t b) {
    return (places.col(static_cast<Eigen::Index>(a)) - places.col(static_cast<Eigen::Index>(b)))
        .squaredNorm();
  };
  const Eigen::VectorXd mean = places.rowwise().mean();
  Eigen::Index first = 0;
  (places.colwise() - mean).colwise().squaredNorm().minCoeff(&first);
  // Every row that is left belongs to the chosen one nearest to it. By the triangle inequality a
  // newly chosen row takes none of another's whose distance to it is twice that one's farthest.
  struct Cell {
    std::size_t chosen;
    std::vector<std::size_t> rows;
    double farthest = -1;  // squared
    std::size_t at = 0;
  };
  std::vector<double> nearest(rows.size());
  std::vector<Cell> cells;
  const auto settle = [&nearest](Cell& cell) {
    cell.farthest = -1;
    for (const std::size_t row : cell.rows)
      if (nearest[row] > cell.farthest || (nearest[row] == cell.farthest && row < cell.at)) {
        cell.farthest = nearest[row];
        cell.at = row;
      }
  };
  Cell all{.chosen = static_cast<std::size_t>(first), .rows = {}};
  for (std::size_t row = 0; row < rows.size(); ++row) {
    if (row == all.chosen) continue;
    nearest[row] = square(row, all.chosen);
    all.rows.push_back(row);
  }
  settle(all);
  std::vector<std::size_t> order = {rows[all.chosen]};
  cells.push_back(std::move(all));
  while (order.size() < count) {
    const auto from = std::ranges::max_element(cells, [](const Cell& a, const Cell& b) {
      return a.farthest < b.farthest || (a.farthest == b.farthest && a.at > b.at);
    });
    Cell next{.chosen = from->at, .rows = {}};
    order.push_back(rows[next.chosen]);
    for (auto& cell : cells) {
      const bool reached = square(cell.chosen, next.chosen) < 4.000001 * cell.farthest;
      if (!reached && &cell != &*from) continue;
      const auto taken = std::ranges::partition(cell.rows, [&](std::size_t row) {
        if (row == next.chosen) return false;
        const double distance = square(row, next.chosen);
        if (distance >= nearest[row]) return true;
        nearest[row] = distance;
        return false;
      });
      for (const std::size_t row : taken)
        if (row != next.chosen) next.rows.push_back(row);
      if (taken.empty()) continue;
      cell.rows.erase(taken.begin(), taken.end());
      settle(cell);
    }
    settle(next);
    cells.push_back(std::move(next));
  }
  return order;
}

Result<LearningCurve> learning_curve(const Dataset& whole, const CurveOptions& options) {
  const auto& candidates = options.fit.candidates;
  if (candidates.outputs.empty())
    return fail(ErrorCode::invalid_argument, reasons::kNoOutput, "the formula predicts nothing");
  const auto inputs = inputs_of_terms(candidates);
  std::vector<std::string> needed = candidates.outputs;
  needed.insert(needed.end(), inputs.begin(), inputs.end());
  const Dataset dataset = without_incomplete_rows(whole, needed);
  MethodOptions method{.fit = options.fit, .mechanism = nullptr};
  method.fit.blocks = 0;
  DRIFTWISE_TRY(const auto model, calibration::fit(dataset, method.fit));
  std::vector<Channel> outputs;
  for (const auto& output : model.outputs) {
    outputs.push_back(output.channel);
    if (output.channel.unit != outputs.front().unit)
      return fail(ErrorCode::invalid_argument, reasons::kUnitsDisagree,
                  "outputs in " + output.channel.unit + " and " + outputs.front().unit +
                      " have no common figure: ask for each kind by itself");
  }
  DRIFTWISE_TRY(auto measured, measured_outputs(dataset, outputs));
  const Bench bench{dataset, Method::stepwise, method, std::move(measured)};

  LearningCurve curve;
  const auto rows = rows_in(dataset, PointSet::calibration);
  curve.rows = static_cast<std::int64_t>(rows.size());
  curve.unit = outputs.front().unit;
  curve.terms = static_cast<std::int64_t>(candidates.terms.size()) + 1;
  std::vector<Fold> folds;
  if (options.together.empty()) {
    folds = time_folds(rows, options.folds, options.gap);
    curve.held_out = std::to_string(options.folds) + " blocks of time";
  } else {
    DRIFTWISE_TRY(const auto labels, group_labels(dataset, options.together));
    folds = group_folds(rows, labels, options.folds);
    curve.held_out =
        std::to_string(options.folds) + " folds, rows of one " + options.together + " together";
  }
  if (folds.size() < 2)
    return fail(ErrorCode::invalid_argument, reasons::kNoBlocks,
                std::to_string(rows.size()) + " calibration rows do not make " + curve.held_out +
                    ": ask for fewer folds");
  std::size_t most = rows.size();
  for (const auto& fold : folds) most = std::min(most, fold.train.size());
  const auto least = std::min<std::size_t>(most, static_cast<std::size_t>(curve.terms) + 3);
  std::vector<std::size_t> sizes;
  for (int k = 0; k < options.sizes; ++k) {
    const double share = options.sizes > 1 ? static_cast<double>(k) / (options.sizes - 1) : 1;
    const auto size = static_cast<std::size_t>(
        std::lround(static_cast<double>(least) *
                    std::pow(static_cast<double>(most) / static_cast<double>(least), share)));
    if (sizes.empty() || size > sizes.back()) sizes.push_back(size);
  }
  // The rows of each fold in the orders in which they would be taken: the spread one, then the
  // random ones.
  std::vector<std::vector<std::vector<std::size_t>>> orders(folds.size());
  // The largest size leaves out a few rows at most: which ones is left to chance.
  const std::size_t filled = sizes.size() > 1 ? sizes[sizes.size() - 2] : sizes.back();
  calibration::run_on(options.fit.executor, folds.size(), [&](std::size_t f) {
    std::mt19937_64 random(options.seed * 1000 + f);
    for (int draw = 0; draw < std::max(1, options.draws); ++draw) {
      auto shuffled = folds[f].train;
      for (std::size_t i = shuffled.size(); i > 1; --i)
        std::swap(shuffled[i - 1], shuffled[random() % i]);
      orders[f].push_back(std::move(shuffled));
    }
    auto filling = spread_order(dataset, folds[f].train, inputs, filled);
    const std::set<std::size_t> taken(filling.begin(), filling.end());
    for (const std::size_t row : orders[f].front())
      if (!taken.contains(row)) filling.push_back(row);
    orders[f].resize(static_cast<std::size_t>(options.draws));
    orders[f].insert(orders[f].begin(), std::move(filling));
  });
  const std::size_t designs = 1 + static_cast<std::size_t>(options.draws);
  const std::size_t jobs = sizes.size() * folds.size() * designs;
  std::vector<std::vector<std::vector<double>>> errors(jobs);  // [job][output]
  calibration::run_on(options.fit.executor, jobs, [&](std::size_t job) {
    const std::size_t size = sizes[job / (folds.size() * designs)];
    const std::size_t f = job / designs % folds.size(), design = job % designs;
    Fold part{.train = orders[f][design], .test = folds[f].test};
    part.train.resize(size);
    std::ranges::sort(part.train);
    const auto found = bench.errors_of(part);
    if (!found) return;
    for (const auto& output : *found)
      errors[job].emplace_back(output.data(), output.data() + output.size());
  });
  for (std::size_t s = 0; s < sizes.size(); ++s) {
    CurvePoint point{.rows = static_cast<std::int64_t>(sizes[s]), .random = {}, .spread = {}};
    std::vector<std::vector<std::vector<double>>> spread, random;
    for (std::size_t f = 0; f < folds.size(); ++f) {
      const std::size_t first = (s * folds.size() + f) * designs;
      spread.push_back(errors[first]);
      // All draws of a fold are one: they share the rows held out.
      std::vector<std::vector<double>> all;
      for (std::size_t design = 1; design < designs; ++design)
        all.insert(all.end(), errors[first + design].begin(), errors[first + design].end());
      random.push_back(std::move(all));
    }
    point.spread = figure_of(spread);
    point.random = figure_of(random);
    curve.points.push_back(point);
  }
  const auto& last = curve.points.back();
  if (!last.spread)
    return fail(ErrorCode::failed_precondition, reasons::kTooFewRows,
                "a fold leaves too few rows to fit the formula: ask for more folds or fewer terms");
  for (const auto& point : curve.points)
    if (point.spread && point.spread->a90 <= 1.05 * last.spread->a90) {
      curve.enough = point.rows;
      break;
    }
  // At the curve's end, whatever sizes were asked for: from half of the rows on.
  const auto from_half =
      std::ranges::find_if(curve.points.rbegin(), curve.points.rend(),
                           [&](const CurvePoint& point) { return 2 * point.rows <= last.rows; });
  if (from_half != curve.points.rend()) {
    const auto& before = *from_half;
    if (before.random && last.random && before.rows < last.rows) {
      const double slope =
          std::log(last.random->a90 / before.random->a90) /
          std::log(static_cast<double>(last.rows) / static_cast<double>(before.rows));
      curve.gain_of_doubling = std::max(0.0, 1 - std::pow(2.0, slope));
    }
  }
  return curve;
}

}  // namespace driftwise::identification
