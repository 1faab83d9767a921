#include "server/calibration/report/held_out.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "server/calibration/linear/row_qr.h"
#include "server/calibration/linear/solution.h"
#include "server/calibration/selection/starts.h"
#include "server/core/try.h"

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

// What one block adds: the errors of its rows per output, or why nothing could be fitted.
struct BlockErrors {
  std::vector<tl::expected<Eigen::VectorXd, std::string>> errors;
};

// What the terms' columns are over some rows, in the order of the terms.
struct ColumnSizes {
  Eigen::VectorXd whole;   // norm, but for what the constant has
  Eigen::VectorXd beyond;  // of it, what is left beyond the columns before it
};

ColumnSizes sizes_of(const Triangle& triangle, bool constant) {
  const Index skip = constant ? 1 : 0, count = triangle.columns.cols();
  const Eigen::MatrixXd columns = triangle.columns.bottomRows(triangle.columns.rows() - skip);
  ColumnSizes sizes{columns.colwise().norm().transpose(), Eigen::VectorXd::Zero(count)};
  Eigen::MatrixXd basis(columns.rows(), count);
  Index found = 0;
  for (Index j = 0; j < count; ++j) {
    Eigen::VectorXd rest = columns.col(j);
    for (int pass = 0; pass < 2; ++pass)  // twice is enough
      rest -= basis.leftCols(found) * (basis.leftCols(found).transpose() * rest).eval();
    sizes.beyond[j] = rest.norm();
    if (sizes.beyond[j] > 1e-13 * sizes.whole[j] && found < basis.rows())
      basis.col(found++) = rest / sizes.beyond[j];
  }
  return sizes;
}

// Over all rows; nothing where these are too much alike for X'X.
std::optional<ColumnSizes> sizes_of_all(const Design& design, const RowReduction& reduction) {
  std::vector<std::size_t> all(reduction.pieces());
  std::iota(all.begin(), all.end(), std::size_t{0});
  const auto triangle = reduction.triangle(all);
  if (!triangle) return std::nullopt;
  return sizes_of(*triangle, design.constant);
}

// Terms that the rows outside a block determine as all rows do. A step inside the block is a
// constant of them, datum(k) is zero or adds up to the constant, of three loads two are left: such
// a column varies there by rounding alone, or is the sum of those before it.
std::vector<int> determined(const Design& design, const Triangle& triangle,
                            const ColumnSizes& over_all) {
  constexpr double kRounding = 1e-10, kAlreadyThere = 1e-4;
  const ColumnSizes here = sizes_of(triangle, design.constant);
  std::vector<int> columns;
  for (Index j = 0; j < here.whole.size(); ++j) {
    const bool is_constant = j == 0 && design.constant;
    if (is_constant ||
        (here.whole[j] > kRounding * over_all.whole[j] &&
         here.beyond[j] * over_all.whole[j] > kAlreadyThere * over_all.beyond[j] * here.whole[j]))
      columns.push_back(static_cast<int>(j));
  }
  return columns;
}

std::string cannot_fit(Index begin, Index end, std::int64_t rows, std::size_t terms) {
  return "without rows " + std::to_string(begin + 1) + " to " + std::to_string(end) +
         " of the fit " + std::to_string(rows) + " are left for " + std::to_string(terms) +
         " terms";
}

std::optional<BlockErrors> judge(const Design& design, const SelectionRule& rule,
                                 const RowReduction& reduction, const ColumnSizes& over_all,
                                 std::size_t held) {
  const Training training = training_without(design, reduction, held);
  const auto triangle = reduction.triangle(training.pieces);
  if (!triangle) return std::nullopt;
  const auto outputs = static_cast<Index>(design.outputs.size());
  const Index begin = reduction.cuts()[3 * held], end = reduction.cuts()[3 * held + 3];
  BlockErrors result;
  Eigen::MatrixXd monomials = Eigen::MatrixXd::Zero(design.monomials(), outputs);
  const auto offered = rule.stepwise ? std::vector<int>{} : determined(design, *triangle, over_all);
  for (Index o = 0; o < outputs; ++o) {
    std::vector<int> columns;
    if (rule.stepwise)
      columns =
          select_from_starts(*triangle, design.basis, design.always, o, rule).selection.set.order();
    for (const int j : offered)
      if (!rule.leaves_out(o, j)) columns.push_back(j);
    Solution solution = solve(*triangle, design.basis, columns, o);
    while (!solution.deficient.empty() && !columns.empty()) {
      std::erase_if(columns, [&](int j) {
        return std::ranges::find(solution.deficient, j) != solution.deficient.end();
      });
      solution = solve(*triangle, design.basis, columns, o);
    }
    if (solution.dof < 1) {
      result.errors.emplace_back(
          tl::unexpected(cannot_fit(begin, end, training.rows, columns.size())));
      continue;
    }
    monomials.col(o) = solution.monomials;
    result.errors.emplace_back(Eigen::VectorXd());
  }
  const Eigen::MatrixXd errors = errors_on(design, begin, end, monomials);
  const auto datums =
      std::span(design.datum)
          .subspan(static_cast<std::size_t>(begin), static_cast<std::size_t>(end - begin));
  for (Index o = 0; o < outputs; ++o) {
    auto& of_output = result.errors[static_cast<std::size_t>(o)];
    if (!of_output) continue;
    *of_output = errors.col(o);
    if (design.constant) judge_untrained(datums, training.datums, *of_output);
  }
  return result;
}

BlockResult summarise(const std::vector<BlockErrors>& blocks, std::size_t output) {
  std::vector<ErrorSums> folds;
  BlockOutcome outcome;
  for (const auto& block : blocks) {
    DRIFTWISE_TRY(const auto errors, block.errors[output]);
    ErrorSums fold;
    for (const double error : errors)
      if (std::isfinite(error)) fold.add(error);
    if (fold.rows > 0) folds.push_back(fold);
    outcome.errors.insert(outcome.errors.end(), errors.begin(), errors.end());
  }
  if (folds.size() < 2)
    return tl::unexpected(
        std::string("rows of datums that are measured once each, all of them in "
                    "one block, say nothing of their errors"));
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

std::vector<BlockResult> held_out_by_blocks(const Design& design, const RowReduction& reduction,
                                            const SelectionRule& rule, const Executor& executor) {
  std::vector<std::optional<BlockErrors>> errors(reduction.pieces() / 3);
  if (const auto over_all = sizes_of_all(design, reduction))
    run_on(executor, errors.size(),
           [&](std::size_t b) { errors[b] = judge(design, rule, reduction, *over_all, b); });
  // Without a block the rest may be too much alike for X'X.
  if (!std::ranges::all_of(errors, [](const auto& one) { return one.has_value(); })) {
    const RowReduction exact(design, reduction.cuts(), Solver::qr, executor);
    return held_out_by_blocks(design, exact, rule, executor);
  }
  std::vector<BlockErrors> blocks;
  for (auto& one : errors) blocks.push_back(std::move(*one));
  std::vector<BlockResult> results;
  for (std::size_t o = 0; o < design.outputs.size(); ++o) results.push_back(summarise(blocks, o));
  return results;
}

}  // namespace driftwise::calibration
