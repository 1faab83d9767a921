#include "server/calibration/report/held_out.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "server/calibration/linear/row_qr.h"
#include "server/calibration/linear/solution.h"
#include "server/calibration/selection/starts.h"

namespace driftwise::calibration {
namespace {

using Eigen::Index;

// Pieces 3 b, 3 b + 1 and 3 b + 2 of the reduction are block b's head, middle and tail: head and
// tail are the gaps of its neighbours.
struct Training {
  std::vector<std::size_t> pieces;
  std::int64_t rows = 0;
  std::set<int> datums;
};

Training training_without(const Design& design, const RowReduction& reduction, std::size_t held) {
  Training training;
  int last = -1;
  for (std::size_t piece = 0; piece < reduction.pieces(); ++piece) {
    const bool gap_before = held > 0 && piece == 3 * held - 1, gap_after = piece == 3 * held + 3;
    if (piece / 3 == held || gap_before || gap_after) continue;
    training.pieces.push_back(piece);
    const Index begin = reduction.cuts()[piece], end = reduction.cuts()[piece + 1];
    training.rows += end - begin;
    for (Index row = begin; row < end; ++row) {
      const int datum = design.datum[static_cast<std::size_t>(row)];
      if (datum != last) training.datums.insert(datum);
      last = datum;
    }
  }
  return training;
}

// Rows of a datum outside the training: about their mean.
void centre_untrained(const Design& design, Index begin, const std::set<int>& trained,
                      Eigen::VectorXd& errors) {
  std::map<int, std::pair<double, int>> untrained;
  const auto datum_of = [&](Index row) {
    return design.datum[static_cast<std::size_t>(begin + row)];
  };
  for (Index row = 0; row < errors.size(); ++row) {
    if (trained.contains(datum_of(row))) continue;
    auto& [sum, count] = untrained[datum_of(row)];
    sum += errors[row];
    ++count;
  }
  if (untrained.empty()) return;
  for (Index row = 0; row < errors.size(); ++row) {
    const auto at = untrained.find(datum_of(row));
    if (at != untrained.end()) errors[row] -= at->second.first / at->second.second;
  }
}

// rows [begin, end): measured less predicted by each column of monomials (one per output).
Eigen::MatrixXd errors_on(const Design& design, Index begin, Index end,
                          const Eigen::MatrixXd& monomials) {
  const Index m = design.monomials(), outputs = monomials.cols();
  const auto& means = design.columns.means();
  // The rows stand about the means, times the root of the weight, which is their first column.
  const Eigen::RowVectorXd shift =
      means.tail(outputs).transpose() - means.head(m).transpose() * monomials;
  Eigen::MatrixXd errors(end - begin, outputs);
  const Index step = block_rows(design.width());
  Eigen::MatrixXd block(std::min(step, end - begin), design.width());
  for (Index at = begin; at < end; at += step) {
    auto rows = block.topRows(std::min(step, end - at));
    design.fill(at, rows);
    auto some = errors.middleRows(at - begin, rows.rows());
    some.noalias() = rows.rightCols(outputs) - rows.leftCols(m) * monomials;
    some.noalias() += rows.col(0) * shift;
    if (design.weighted) some.array().colwise() /= rows.col(0).array();
  }
  return errors;
}

// What one block adds: the errors of its rows per output; none where nothing could be fitted.
struct BlockErrors {
  std::vector<std::optional<Eigen::VectorXd>> errors;
};

// Norms of the terms' columns over all rows; nothing where these are too much alike for X'X.
std::optional<Eigen::VectorXd> lengths_of(const RowReduction& reduction) {
  std::vector<std::size_t> all(reduction.pieces());
  std::iota(all.begin(), all.end(), std::size_t{0});
  const auto triangle = reduction.triangle(all);
  if (!triangle) return std::nullopt;
  return triangle->columns.colwise().norm().transpose();
}

// A step inside the block is a constant of the rows outside, and datum(k) is zero: such a column
// varies there by rounding alone, and has no coefficient from them. length: over all rows.
bool varies(const Triangle& triangle, int column, bool constant, double length) {
  constexpr double kRounding = 1e-10;
  const auto all = triangle.columns.col(column);
  return (constant ? all.tail(all.size() - 1).norm() : all.norm()) > kRounding * length;
}

std::optional<BlockErrors> judge(const Design& design, const SelectionRule& rule,
                                 const RowReduction& reduction, const Eigen::VectorXd& lengths,
                                 std::size_t held) {
  const Training training = training_without(design, reduction, held);
  const auto triangle = reduction.triangle(training.pieces);
  if (!triangle) return std::nullopt;
  const auto outputs = static_cast<Index>(design.outputs.size());
  BlockErrors result;
  result.errors.resize(design.outputs.size());
  Eigen::MatrixXd monomials = Eigen::MatrixXd::Zero(design.monomials(), outputs);
  std::vector<Index> fitted;
  for (Index o = 0; o < outputs; ++o) {
    if (!rule.stepwise && training.rows <= static_cast<std::int64_t>(design.terms.size())) continue;
    std::vector<int> columns;
    if (rule.stepwise) {
      columns =
          select_from_starts(*triangle, design.basis, design.always, o, rule).selection.set.order();
    } else {
      for (int j = 0; j < static_cast<int>(design.terms.size()); ++j)
        if (((j == 0 && design.constant) || varies(*triangle, j, design.constant, lengths[j])) &&
            !rule.leaves_out(o, j))
          columns.push_back(j);
    }
    const Solution solution = solve(*triangle, design.basis, columns, o);
    if (!solution.deficient.empty() || solution.dof < 1) continue;
    monomials.col(o) = solution.monomials;
    fitted.push_back(o);
  }
  const Index begin = reduction.cuts()[3 * held], end = reduction.cuts()[3 * held + 3];
  const Eigen::MatrixXd errors = errors_on(design, begin, end, monomials);
  for (const Index o : fitted) {
    Eigen::VectorXd one = errors.col(o);
    if (design.constant) centre_untrained(design, begin, training.datums, one);
    result.errors[static_cast<std::size_t>(o)] = std::move(one);
  }
  return result;
}

std::optional<BlockOutcome> summarise(const std::vector<BlockErrors>& blocks, std::size_t output) {
  std::vector<ErrorSums> folds;
  BlockOutcome outcome;
  for (const auto& block : blocks) {
    if (!block.errors[output]) return std::nullopt;
    auto& fold = folds.emplace_back();
    for (const double error : *block.errors[output]) fold.add(error);
    outcome.errors.insert(outcome.errors.end(), block.errors[output]->begin(),
                          block.errors[output]->end());
  }
  outcome.figure = held_out_figure(folds);
  return outcome;
}

}  // namespace

std::vector<Index> block_cuts(const Design& design, int blocks, double gap) {
  const Index rows = design.row_count();
  std::vector<Index> cuts;
  if (blocks < 2 || rows < 3 * blocks) return cuts;
  for (int b = 0; b < blocks; ++b) {
    const Index begin = rows * b / blocks, end = rows * (b + 1) / blocks;
    const auto margin = std::min<Index>(
        static_cast<Index>(std::lround(gap * static_cast<double>(end - begin))), (end - begin) / 2);
    cuts.insert(cuts.end(), {begin, begin + margin, end - margin});
  }
  cuts.push_back(rows);
  return cuts;
}

std::vector<std::optional<BlockOutcome>> held_out_by_blocks(const Design& design,
                                                            const RowReduction& reduction,
                                                            const SelectionRule& rule,
                                                            const Executor& executor) {
  std::vector<std::optional<BlockErrors>> errors(reduction.pieces() / 3);
  if (const auto lengths = lengths_of(reduction))
    run_on(executor, errors.size(),
           [&](std::size_t b) { errors[b] = judge(design, rule, reduction, *lengths, b); });
  // Without a block the rest may be too much alike for X'X.
  if (!std::ranges::all_of(errors, [](const auto& one) { return one.has_value(); })) {
    const RowReduction exact(design, reduction.cuts(), Solver::qr, executor);
    return held_out_by_blocks(design, exact, rule, executor);
  }
  std::vector<BlockErrors> blocks;
  for (auto& one : errors) blocks.push_back(std::move(*one));
  std::vector<std::optional<BlockOutcome>> results;
  for (std::size_t o = 0; o < design.outputs.size(); ++o) results.push_back(summarise(blocks, o));
  return results;
}

}  // namespace driftwise::calibration
