#include "server/calibration/linear/solution.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace driftwise::calibration {
namespace {

using Eigen::Index;
using Long = long double;
using LongMatrix = Eigen::Matrix<Long, Eigen::Dynamic, Eigen::Dynamic>;
using LongVector = Eigen::Matrix<Long, Eigen::Dynamic, 1>;

constexpr Long kDeficient = 1e-8L;

// Terms by their own monomial: parts before products, so that T is triangular.
struct Layout {
  std::vector<int> columns;  // terms, by top
  std::vector<Index> place;  // monomial -> position in columns, or -1
};

Layout lay_out(const Basis& basis, std::vector<int> columns) {
  const auto top = [&basis](int column) {
    return basis.expansions[static_cast<std::size_t>(column)].top;
  };
  std::ranges::sort(columns, {}, top);
  Layout layout{std::move(columns), std::vector<Index>(basis.monomials.size(), -1)};
  for (std::size_t i = 0; i < layout.columns.size(); ++i)
    layout.place[static_cast<std::size_t>(top(layout.columns[i]))] = static_cast<Index>(i);
  return layout;
}

// B = E T. T: k x k, upper triangular. E: m x k, the identity on the terms' own monomials.
void factor(const Basis& basis, const Layout& layout, LongMatrix& e, LongMatrix& t) {
  const auto k = static_cast<Index>(layout.columns.size());
  const auto m = static_cast<Index>(basis.monomials.size());
  t = LongMatrix::Zero(k, k);
  e = LongMatrix::Zero(m, k);
  bool extras = false;
  for (Index c = 0; c < k; ++c) {
    for (const auto& [monomial, value] :
         basis.expansions[static_cast<std::size_t>(layout.columns[static_cast<std::size_t>(c)])]
             .parts) {
      const Index at = layout.place[static_cast<std::size_t>(monomial)];
      if (at >= 0) {
        t(at, c) = value;
      } else {
        e(monomial, c) = value;
        extras = true;
      }
    }
  }
  if (extras) {  // e := e t^-1, column by column; only rows that are nobody's own monomial
    for (Index c = 0; c < k; ++c) {
      for (Index before = 0; before < c; ++before)
        if (t(before, c) != 0) e.col(c) -= e.col(before) * t(before, c);
      e.col(c) /= t(c, c);
    }
  }
  for (Index monomial = 0; monomial < m; ++monomial)
    if (const Index at = layout.place[static_cast<std::size_t>(monomial)]; at >= 0)
      e(monomial, at) = 1;
}

// Householder QR of g (r x k) applied to z as well. Columns are zero below depth[c], ascending:
// only what is there is reflected, which for a complete set of monomials is nothing at all.
// constant: g.col(0) is the constant, and a column is judged by what varies in it.
std::vector<int> triangularise(LongMatrix& g, LongVector& z, const std::vector<Index>& depth,
                               bool constant) {
  std::vector<int> deficient;
  const Index rows = g.rows(), k = g.cols();
  const LongVector whole = constant
                               ? LongVector(g.bottomRows(rows - 1).colwise().norm().transpose())
                               : LongVector(g.colwise().norm().transpose());
  for (Index c = 0; c < k; ++c) {
    const Index last = std::min(rows - 1, depth[static_cast<std::size_t>(c)]);
    const Index length = last - c + 1;
    Long left = 0;
    if (length >= 1) {
      if (length > 1) {
        LongVector v = g.col(c).segment(c, length);
        const Long norm = v.norm();
        const Long alpha = v[0] > 0 ? -norm : norm;
        v[0] -= alpha;
        const Long scale = v.squaredNorm();
        if (scale > 0) {
          for (Index j = c + 1; j < k; ++j) {
            const Long step = 2 * v.dot(g.col(j).segment(c, length)) / scale;
            g.col(j).segment(c, length) -= step * v;
          }
          const Long step = 2 * v.dot(z.segment(c, length)) / scale;
          z.segment(c, length) -= step * v;
        }
        g.col(c).segment(c, length).setZero();
        g(c, c) = alpha;
      }
      left = std::abs(g(c, c));
    }
    if (!(left > kDeficient * whole[c]) && !(constant && c == 0 && left > 0))
      deficient.push_back(static_cast<int>(c));
  }
  return deficient;
}

}  // namespace

Eigen::MatrixXd Solution::covariance() const {
  if (dof < 1) return Eigen::MatrixXd::Zero(root.rows(), root.rows());
  return (rss / dof) * (root * root.transpose());
}

double Solution::standard_error(Index i) const {
  return dof < 1 ? 0 : std::sqrt(rss / dof) * root.row(i).norm();
}

Solution solve(const Triangle& triangle, const Basis& basis, std::vector<int> columns,
               Index output) {
  Solution solution;
  std::ranges::sort(columns);
  solution.columns = columns;
  const Layout layout = lay_out(basis, std::move(columns));
  const auto k = static_cast<Index>(layout.columns.size());
  const Index r = triangle.monomials.rows();
  LongMatrix e, t;
  factor(basis, layout, e, t);

  LongMatrix g = LongMatrix::Zero(r, k);
  std::vector<Index> depth(static_cast<std::size_t>(k));
  for (Index c = 0; c < k; ++c) {
    for (Index monomial = 0; monomial < e.rows(); ++monomial) {
      if (e(monomial, c) == 0) continue;
      const Index height = std::min(r, monomial + 1);
      g.col(c).head(height) +=
          e(monomial, c) * triangle.monomials.col(monomial).head(height).cast<Long>();
      depth[static_cast<std::size_t>(c)] = std::max(depth[static_cast<std::size_t>(c)], monomial);
    }
    if (c > 0)
      depth[static_cast<std::size_t>(c)] =
          std::max(depth[static_cast<std::size_t>(c)], depth[static_cast<std::size_t>(c) - 1]);
  }
  LongVector z = triangle.outputs.col(output).cast<Long>();
  const bool constant = k > 0 && layout.place[0] == 0;
  std::vector<int> deficient = k > r ? std::vector<int>{} : triangularise(g, z, depth, constant);
  if (k > r) {
    deficient.resize(static_cast<std::size_t>(k - r));
    std::iota(deficient.begin(), deficient.end(), static_cast<int>(r));
  }
  for (const int c : deficient)
    solution.deficient.push_back(layout.columns[static_cast<std::size_t>(c)]);
  solution.dof = static_cast<int>(triangle.rows - k);
  if (!deficient.empty()) return solution;

  solution.rss = triangle.beyond[output] + static_cast<double>(z.tail(r - k).squaredNorm());
  const auto upper = g.topRows(k).template triangularView<Eigen::Upper>();
  const LongVector in_monomials = upper.solve(z.head(k));
  const LongMatrix inverse = upper.solve(LongMatrix::Identity(k, k));
  const auto back = t.template triangularView<Eigen::Upper>();
  const LongVector raw = back.solve(in_monomials);
  const LongMatrix root = back.solve(inverse);

  solution.shape = e.template cast<double>();
  solution.to_orthonormal = inverse.template cast<double>();
  solution.monomials = (e * in_monomials).template cast<double>();
  solution.coefficients.resize(k);
  solution.root.resize(k, k);
  for (Index c = 0; c < k; ++c) {  // from the layout's order to ascending columns
    const auto at =
        std::ranges::lower_bound(solution.columns, layout.columns[static_cast<std::size_t>(c)]);
    const Index row = at - solution.columns.begin();
    solution.coefficients[row] = static_cast<double>(raw[c]);
    solution.root.row(row) = root.row(c).template cast<double>();
  }
  return solution;
}

}  // namespace driftwise::calibration
