#include "server/calibration/linear/row_reduction.h"

#include <algorithm>

#include "server/calibration/linear/gram.h"
#include "server/calibration/linear/row_qr.h"
#include "server/calibration/linear/tall_kernels.h"
#include "server/effects/term_order.h"

namespace driftwise::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// Of rows that one thread works on at a time; fixed, so that threads do not change the result.
constexpr Index kUnitRows = 4096;
// Below about a millisecond of reflections there is nothing to win.
constexpr double kWorthGram = 1e7;     // rows x width^2
constexpr Index kTall = 16;            // rows per column
constexpr Index kPreliminaryRows = 4;  // per column

struct Unit {
  std::size_t piece;
  Index begin, end;
};

std::vector<Unit> units_of(const std::vector<Index>& cuts) {
  std::vector<Unit> units;
  for (std::size_t piece = 0; piece + 1 < cuts.size(); ++piece)
    for (Index at = cuts[piece]; at < cuts[piece + 1]; at += kUnitRows)
      units.push_back({piece, at, std::min(at + kUnitRows, cuts[piece + 1])});
  return units;
}

// Passes the unit's rows on in blocks that fit the cache: use(block, count), block with padded
// rows.
template <class Use>
void for_each_block(const Design& design, const Unit& unit, Use use) {
  const Index step = block_rows(design.width());
  MatrixXd block(tall::padded(std::min(step, unit.end - unit.begin)), design.width());
  for (Index at = unit.begin; at < unit.end; at += step) {
    const Index count = std::min(step, unit.end - at);
    design.fill(at, block.topRows(count));
    use(block, count);
  }
}

MatrixXd triangle_of_unit(const Design& design, const Unit& unit) {
  GrowingTriangle growing(design.width());
  for_each_block(design, unit, [&](MatrixXd& block, Index count) { growing.add(block, count); });
  return growing.triangle();
}

MatrixXd gram_of_unit(const Design& design, const Unit& unit, const MatrixXd& preliminary) {
  MatrixXd gram = MatrixXd::Zero(design.width(), design.width());
  for_each_block(design, unit, [&](MatrixXd& block, Index count) {
    block.bottomRows(block.rows() - count).setZero();
    const tall::Block all{block.data(), block.rows(), tall::padded(count), block.cols()};
    const Index m = design.monomials();
    tall::subtract_product(all.head(m), preliminary.data(), m, all.from_column(m));
    tall::add_gram(all, gram.data());
  });
  return gram;
}

// Least squares on some of the rows; columns that these rows do not settle get 0.
MatrixXd solution_on_some_rows(const Design& design) {
  const Index m = design.monomials(), outputs = design.width() - m;
  const auto count = std::min(design.row_count(), kPreliminaryRows * design.width());
  std::vector<std::size_t> rows(static_cast<std::size_t>(count));
  for (Index i = 0; i < count; ++i)
    rows[static_cast<std::size_t>(i)] =
        design.rows[static_cast<std::size_t>(design.row_count() * i / count)];
  MatrixXd some(count, design.width());
  design.columns.fill(rows, some);
  const MatrixXd r = row_qr(some);
  MatrixXd solution = MatrixXd::Zero(m, outputs);
  for (Index j = std::min(m, r.rows()) - 1; j >= 0; --j) {
    if (!(r(j, j) * r(j, j) > kSafePivot * r.col(j).squaredNorm())) continue;
    solution.row(j) = (r.row(j).tail(outputs) -
                       r.row(j).segment(j + 1, m - j - 1) * solution.bottomRows(m - j - 1)) /
                      r(j, j);
  }
  return solution;
}

}  // namespace

RowReduction::RowReduction(const Design& design, std::vector<Index> cuts, Solver wanted,
                           const Executor& executor)
    : design_(design), cuts_(std::move(cuts)) {
  const auto rows = static_cast<double>(design.row_count());
  const auto width = static_cast<double>(design.width());
  const bool many =
      design.row_count() >= kTall * design.width() && rows * width * width >= kWorthGram;
  if (wanted == Solver::gram || (wanted == Solver::automatic && many)) solver_ = Solver::gram;
  if (solver_ == Solver::gram) {
    preliminary_ = solution_on_some_rows(design_);
    reduce(executor);
    note_ = why_not_gram();
    if (note_.empty()) return;
    solver_ = Solver::qr;
  }
  reduce(executor);
}

void RowReduction::reduce(const Executor& executor) {
  const auto units = units_of(cuts_);
  std::vector<MatrixXd> reduced(units.size());
  run_on(executor, units.size(), [&](std::size_t i) {
    reduced[i] = solver_ == Solver::gram ? gram_of_unit(design_, units[i], preliminary_)
                                         : triangle_of_unit(design_, units[i]);
  });
  parts_.assign(pieces(), MatrixXd());
  std::vector<std::vector<std::size_t>> members(pieces());
  for (std::size_t i = 0; i < units.size(); ++i) members[units[i].piece].push_back(i);
  run_on(executor, pieces(), [&](std::size_t piece) {
    std::vector<MatrixXd> triangles;
    for (const std::size_t i : members[piece]) triangles.push_back(std::move(reduced[i]));
    parts_[piece] = join(triangles);
  });
}

MatrixXd RowReduction::join(const std::vector<MatrixXd>& parts) const {
  if (parts.size() == 1) return parts.front();
  if (parts.empty() && solver_ == Solver::qr) return MatrixXd(0, design_.width());
  if (solver_ == Solver::qr) return join_triangles(parts);
  MatrixXd sum = MatrixXd::Zero(design_.width(), design_.width());
  for (const auto& part : parts) sum += part;
  return sum;
}

std::string RowReduction::why_not_gram() const {
  const GramTriangle whole = gram_triangle(join(parts_), design_.monomials());
  if (whole.joint.size() > 0) return {};
  std::string name;
  for (const auto& [variable, exponent] :
       design_.basis.monomials[static_cast<std::size_t>(whole.worst)])
    name += (name.empty() ? "" : ":") + design_.variables[static_cast<std::size_t>(variable)].name +
            (exponent > 1 ? "^" + std::to_string(exponent) : "");
  return "the fast path by X'X was left for QR: of " + name + " only " +
         effects::number_text(std::max(0.0, whole.worst_pivot)) +
         " is left beyond the columns before it";
}

Triangle RowReduction::all() const {
  std::vector<std::size_t> every(pieces());
  for (std::size_t i = 0; i < every.size(); ++i) every[i] = i;
  return *triangle(every);  // the constructor saw that it is safe
}

std::optional<Triangle> RowReduction::triangle(const std::vector<std::size_t>& chosen) const {
  std::vector<MatrixXd> parts;
  std::int64_t rows = 0;
  for (const std::size_t piece : chosen) {
    parts.push_back(parts_[piece]);
    rows += cuts_[piece + 1] - cuts_[piece];
  }
  const Index m = design_.monomials(), outputs = design_.width() - m;
  MatrixXd joint = join(parts);
  if (solver_ == Solver::gram) {
    joint = gram_triangle(joint, m).joint;
    if (joint.size() == 0) return std::nullopt;
    joint.topRightCorner(m, outputs) +=
        joint.topLeftCorner(m, m).template triangularView<Eigen::Upper>() * preliminary_;
  }
  return make_triangle(std::move(joint), design_.columns.means(), design_.basis, outputs, rows);
}

}  // namespace driftwise::calibration
