#include "server/calibration/design/design_columns.h"

#include <algorithm>
#include <map>

#include "server/effects/term_evaluator.h"

namespace driftwise::calibration {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// The rows of one column: as they lie where the rows follow one another, else gathered.
class RowValues {
 public:
  RowValues(std::span<const double> values, std::span<const std::size_t> rows) {
    if (rows.empty()) return;
    if (rows.back() - rows.front() + 1 == rows.size()) {
      data_ = values.data() + rows.front();
      return;
    }
    gathered_.resize(static_cast<Index>(rows.size()));
    for (std::size_t i = 0; i < rows.size(); ++i)
      gathered_[static_cast<Index>(i)] = values[rows[i]];
    data_ = gathered_.data();
  }
  Eigen::Map<const Eigen::ArrayXd> array(std::size_t count) const {
    return {data_, static_cast<Index>(count)};
  }

 private:
  const double* data_ = nullptr;
  VectorXd gathered_;
};

}  // namespace

DesignColumns::DesignColumns(ColumnSources sources, const std::vector<Variable>& variables,
                             const Basis& basis)
    : sources_(std::move(sources)) {
  for (const auto& variable : variables)
    scales_.push_back({variable.mid, 1 / variable.half});  // exact: half is a power of two
  std::map<Monomial, Index> known;
  for (const auto& monomial : basis.monomials) {
    Column column;
    if (!monomial.empty()) {
      // Parents (one factor less) come first where they are there at all.
      Monomial parent = monomial;
      column.variable = parent.back().first;
      if (--parent.back().second == 0) parent.pop_back();
      column.plain = parent.empty();
      if (const auto at = known.find(parent); !column.plain && at != known.end()) {
        column.parent = at->second;
        plan_[static_cast<std::size_t>(at->second)].parental = true;
      } else if (!column.plain) {
        column.whole = monomial;
      }
    }
    known.emplace(monomial, static_cast<Index>(plan_.size()));
    plan_.push_back(std::move(column));
  }
  means_ = VectorXd::Zero(width());
}

VectorXd DesignColumns::scaled(int variable, std::span<const std::size_t> rows) const {
  const auto v = static_cast<std::size_t>(variable);
  const RowValues values(sources_.variables[v], rows);
  return (values.array(rows.size()) - scales_[v].mid) * scales_[v].inverse;
}

void DesignColumns::fill_plain(const Column& column, std::span<const std::size_t> rows, double mean,
                               Eigen::Ref<VectorXd> out) const {
  const auto v = static_cast<std::size_t>(column.variable);
  const RowValues values(sources_.variables[v], rows);
  out.array() = (values.array(rows.size()) - scales_[v].mid) * scales_[v].inverse - mean;
}

void DesignColumns::fill(std::span<const std::size_t> rows, Eigen::Ref<Eigen::MatrixXd> out) const {
  const auto m = static_cast<Index>(plan_.size());
  std::map<int, VectorXd> factors;  // variables that make columns out of others
  for (Index j = 0; j < m; ++j) {
    const auto& column = plan_[static_cast<std::size_t>(j)];
    if (column.variable < 0) {
      out.col(j).setOnes();
    } else if (column.plain) {
      fill_plain(column, rows, column.parental ? 0 : means_[j], out.col(j));
    } else if (column.parent >= 0) {
      auto at = factors.find(column.variable);
      if (at == factors.end())
        at = factors.emplace(column.variable, scaled(column.variable, rows)).first;
      out.col(j).array() = out.col(column.parent).array() * at->second.array();
    } else {
      out.col(j).setOnes();
      for (const auto& [variable, exponent] : column.whole) {
        const VectorXd u = scaled(variable, rows);
        for (Index row = 0; row < u.size(); ++row) out(row, j) *= effects::power(u[row], exponent);
      }
    }
  }
  for (Index j = 1; j < m; ++j) {
    const auto& column = plan_[static_cast<std::size_t>(j)];
    if ((!column.plain || column.parental) && means_[j] != 0) out.col(j).array() -= means_[j];
  }
  for (std::size_t o = 0; o < sources_.outputs.size(); ++o) {
    const Index j = m + static_cast<Index>(o);
    out.col(j).array() = RowValues(sources_.outputs[o], rows).array(rows.size()) - means_[j];
  }
  if (sources_.weights.empty()) return;
  const Eigen::ArrayXd roots = RowValues(sources_.weights, rows).array(rows.size()).sqrt();
  out.array().colwise() *= roots;
}

void DesignColumns::take_off_means_of(std::span<const std::size_t> rows) {
  means_.setZero();
  if (rows.empty()) return;
  Eigen::MatrixXd block(static_cast<Index>(rows.size()), width());
  fill(rows, block);
  // A weighted row holds the root of its weight: times it once more, the weight.
  const VectorXd ones = block.col(0);
  means_ = block.transpose() * ones / ones.squaredNorm();
  means_[0] = 0;
}

}  // namespace driftwise::calibration
