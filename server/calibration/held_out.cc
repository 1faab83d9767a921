#include "server/calibration/held_out.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "server/calibration/row_qr.h"
#include "server/calibration/solution.h"
#include "server/calibration/starts.h"
#include "server/calibration/tail.h"
#include "server/core/units.h"

namespace driftwise::calibration {
namespace {

using Eigen::Index;

struct Block {
  Index begin, head, tail, end;
};  // [begin, head) and [tail, end) are the gaps of its neighbours

std::vector<Block> cut(Index rows, int blocks, double gap) {
  std::vector<Block> cuts;
  for (int b = 0; b < blocks; ++b) {
    const Index begin = rows * b / blocks, end = rows * (b + 1) / blocks;
    const auto margin = std::min<Index>(
        static_cast<Index>(std::lround(gap * static_cast<double>(end - begin))), (end - begin) / 2);
    cuts.push_back({begin, begin + margin, end - margin, end});
  }
  return cuts;
}

// R of each block's head, middle and tail.
struct Segments {
  Eigen::MatrixXd head, middle, tail;
};

// Errors on one block: per output, or NaN alone where nothing could be fitted.
using BlockErrors = std::vector<Eigen::VectorXd>;

BlockErrors judge(const Design& design, const SelectionRule& rule,
                  const std::vector<Segments>& segments, const std::vector<Block>& cuts,
                  std::size_t held) {
  std::vector<Eigen::MatrixXd> parts;
  std::int64_t rows = 0;
  std::map<int, int> trained;  // datum -> rows
  const auto take = [&](const Eigen::MatrixXd& part, Index begin, Index end) {
    parts.push_back(part);
    rows += end - begin;
    for (Index row = begin; row < end; ++row)
      ++trained[design.datum[static_cast<std::size_t>(row)]];
  };
  for (std::size_t b = 0; b < cuts.size(); ++b) {
    if (b == held) continue;
    if (b != held + 1) take(segments[b].head, cuts[b].begin, cuts[b].head);
    take(segments[b].middle, cuts[b].head, cuts[b].tail);
    if (b + 1 != held) take(segments[b].tail, cuts[b].tail, cuts[b].end);
  }
  const auto outputs = static_cast<Index>(design.outputs.size());
  const Index m = design.monomials();
  const Triangle triangle =
      make_triangle(join_triangles(parts), design.means, design.basis, outputs, rows);
  const Block& block = cuts[held];
  const Index count = block.end - block.begin;
  BlockErrors errors;
  for (Index o = 0; o < outputs; ++o) {
    errors.emplace_back();
    if (!rule.stepwise && rows <= static_cast<std::int64_t>(design.terms.size())) continue;
    std::vector<int> columns;
    if (rule.stepwise) {
      columns =
          select_from_starts(triangle, design.basis, design.always, o, rule).selection.set.order();
    } else {
      for (int j = 0; j < static_cast<int>(design.terms.size()); ++j)
        if (triangle.columns.col(j).squaredNorm() > 0)
          columns.push_back(j);  // datum(k) without rows
    }
    const Solution solution = solve(triangle, design.basis, columns, o);
    if (!solution.deficient.empty() || solution.dof < 1) continue;
    // The matrix stands about its means, times the root of the weight, which is its first column.
    const double shift = design.means[m + o] - design.means.head(m).dot(solution.monomials);
    const auto ones = design.matrix.col(0).segment(block.begin, count);
    Eigen::VectorXd residuals = design.matrix.block(block.begin, m + o, count, 1) -
                                design.matrix.block(block.begin, 0, count, m) * solution.monomials +
                                shift * ones;
    if (design.weighted) residuals.array() /= ones.array();
    if (design.constant) {
      std::map<int, std::pair<double, int>> untrained;
      for (Index row = 0; row < count; ++row) {
        const int datum = design.datum[static_cast<std::size_t>(block.begin + row)];
        if (trained.contains(datum)) continue;
        untrained[datum].first += residuals[row];
        ++untrained[datum].second;
      }
      for (Index row = 0; row < count; ++row) {
        const auto at = untrained.find(design.datum[static_cast<std::size_t>(block.begin + row)]);
        if (at != untrained.end()) residuals[row] -= at->second.first / at->second.second;
      }
    }
    errors.back() = std::move(residuals);
  }
  return errors;
}

std::optional<HeldOut> summarise(const std::vector<BlockErrors>& blocks, std::size_t output) {
  double squares = 0, rows = 0;
  for (const auto& block : blocks) {
    if (block[output].size() == 0) return std::nullopt;
    squares += block[output].squaredNorm();
    rows += static_cast<double>(block[output].size());
  }
  if (!(squares > 0)) return HeldOut{};
  HeldOut result;
  result.u90 = kSigmaToU90 * std::sqrt(squares / rows);
  const auto count = static_cast<double>(blocks.size());
  std::vector<double> left_out;
  double mean = 0;
  for (const auto& block : blocks) {
    left_out.push_back(std::log((squares - block[output].squaredNorm()) /
                                (rows - static_cast<double>(block[output].size()))));
    mean += left_out.back() / count;
  }
  double spread = 0;
  for (const double one : left_out) spread += (one - mean) * (one - mean);
  const double half = t_quantile(0.95, count - 1) * std::sqrt(spread * (count - 1) / count);
  result.low = result.u90 * std::exp(-half / 2);
  result.high = result.u90 * std::exp(half / 2);
  return result;
}

}  // namespace

std::vector<std::optional<HeldOut>> held_out_by_blocks(const Design& design,
                                                       const SelectionRule& rule, int blocks,
                                                       double gap, const Executor& executor) {
  std::vector<std::optional<HeldOut>> results(design.outputs.size());
  const Index rows = design.matrix.rows();
  if (blocks < 2 || rows < 3 * blocks) return results;
  const auto run = [&executor](std::size_t count, const std::function<void(std::size_t)>& job) {
    if (executor) return executor(count, job);
    for (std::size_t i = 0; i < count; ++i) job(i);
  };
  const auto cuts = cut(rows, blocks, gap);
  std::vector<Segments> segments(cuts.size());
  run(cuts.size(), [&](std::size_t b) {
    const auto& block = cuts[b];
    const auto part = [&](Index begin, Index end) {
      return row_qr(design.matrix.middleRows(begin, end - begin));
    };
    segments[b] = {part(block.begin, block.head), part(block.head, block.tail),
                   part(block.tail, block.end)};
  });
  std::vector<BlockErrors> errors(cuts.size());
  run(cuts.size(), [&](std::size_t b) { errors[b] = judge(design, rule, segments, cuts, b); });
  for (std::size_t o = 0; o < results.size(); ++o) results[o] = summarise(errors, o);
  return results;
}

}  // namespace driftwise::calibration
