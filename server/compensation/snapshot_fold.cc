// The algebra of a snapshot: one output's terms folded at the present conditions.
//
// Term k = (slow value s_k) * (basis entry m_k). With a the vector of term values, a = S b, S
// holding s_k in column m_k; anchored, minus the term's value at the datum's zero: S - d e_0'. Then
// q = c'a (+ q at the zero), var q = a' C a; an error that shifts the coefficients by d adds (g'
// b)^2 with g the same fold of d, and one of the slow channel T_j u_j^2 (g_j' b)^2 with g_j that of
// the terms' derivatives. Sums in long double: the covariance of a model in raw temperatures is the
// difference of large numbers. C = W W' from a root W is folded column by column, as the shifts
// are.

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "server/compensation/snapshot_builder.h"

namespace driftwise::compensation {
namespace {

using Wide = long double;

std::size_t packed_size(std::size_t n) { return n * (n + 1) / 2; }

// A sum of quadratic forms over the basis, kept as a full lower triangle.
class Form {
 public:
  explicit Form(std::size_t size) : size_(size), sum_(size * size, 0) {}

  void add(std::size_t i, std::size_t j, Wide value) { sum_[i * size_ + j] += value; }
  // b' V b as compute_target walks over it: lower triangle row by row, off-diagonal entries taken
  // twice.
  std::vector<double> packed_nm2(Wide nm2_per_unit2) const {
    std::vector<double> out;
    out.reserve(packed_size(size_));
    for (std::size_t i = 0; i < size_; ++i)
      for (std::size_t j = 0; j <= i; ++j)
        out.push_back(static_cast<double>(
            nm2_per_unit2 *
            (i == j ? sum_[i * size_ + i] : sum_[i * size_ + j] + sum_[j * size_ + i])));
    return out;
  }

 private:
  std::size_t size_;
  std::vector<Wide> sum_;
};

// The roots of all lines in one triangle, row by row from its diagonal: as many numbers as a form
// has and the digits of a root. What has no root is summed as a form.
void sum_lines(std::size_t size, Snapshot::Output& out) {
  const auto n = static_cast<Eigen::Index>(size);
  Eigen::Index rows = 0;
  for (const auto& line : out.lines)
    rows += static_cast<Eigen::Index>(line.roots_nm.size() / size) +
            (line.variance_nm2.size() == 1 ? 1 : 0);
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(std::max(rows, n), n);
  Eigen::Index at = 0;
  for (const auto& line : out.lines) {
    for (std::size_t from = 0; from + size <= line.roots_nm.size(); from += size)
      all.row(at++) = Eigen::Map<const Eigen::RowVectorXd>(line.roots_nm.data() + from, n);
    if (line.variance_nm2.size() == 1) {
      all(at++, 0) = std::sqrt(line.variance_nm2[0]);
    } else if (!line.variance_nm2.empty()) {
      out.variance_nm2.resize(packed_size(size));
      for (std::size_t i = 0; i < line.variance_nm2.size(); ++i)
        out.variance_nm2[i] += line.variance_nm2[i];
    }
  }
  const Eigen::HouseholderQR<Eigen::MatrixXd> triangle(all);
  for (Eigen::Index row = 0; row < n; ++row)
    for (Eigen::Index column = row; column < n; ++column)
      out.root_nm.push_back(triangle.matrixQR()(row, column));
}

}  // namespace

// b' V b of a model of before, which has its covariance and no root, packed as compute_target walks
// over it. Its digits are lost with the square of what the coefficients lose.
std::vector<double> SnapshotBuilder::form_of(std::size_t index, const std::vector<Wide>& slow,
                                             const std::vector<Wide>& at_zero) const {
  const Output& model = outputs_[index];
  const std::size_t terms = model.terms.size();
  const Wide nm_per_unit = static_cast<Wide>(model.mm_per_unit) * static_cast<Wide>(kNmPerMm);
  std::vector<const Systematic*> at_own_zero;
  if (datum_.empty())
    for (const auto& error : model.systematics)
      if (error.in_rows.size() > 0) at_own_zero.push_back(&error);
  Form fit(basis_.size());
  for (std::size_t k = 0; k < terms; ++k)
    for (std::size_t l = 0; l < terms; ++l) {
      const auto row = static_cast<Eigen::Index>(k), column = static_cast<Eigen::Index>(l);
      Wide c = model.covariance(row, column);
      for (const auto* error : at_own_zero)
        c -= static_cast<Wide>(error->in_rows[row]) * error->in_rows[column];
      const std::size_t m = model.terms[k].basis, n = model.terms[l].basis;
      fit.add(m, n, c * slow[k] * slow[l]);
      fit.add(m, 0, -c * slow[k] * at_zero[l]);
      fit.add(0, n, -c * at_zero[k] * slow[l]);
      fit.add(0, 0, c * at_zero[k] * at_zero[l]);
    }
  return fit.packed_nm2(nm_per_unit * nm_per_unit);
}

Snapshot::Output SnapshotBuilder::fold(std::size_t index, const Conditions& now) const {
  const Output& model = outputs_[index];
  const Datum* datum = datum_.empty() ? nullptr : &datum_[index];
  const std::size_t size = basis_.size(), terms = model.terms.size();
  const Wide nm_per_unit = static_cast<Wide>(model.mm_per_unit) * static_cast<Wide>(kNmPerMm);
  Snapshot::Output out;
  out.channel = model.channel;

  std::vector<Wide> slow(terms), at_zero(terms, 0);
  std::vector<Wide> coefficients(size, 0);
  std::vector<Wide> thermal(now.channels.empty() ? 0 : size, 0);
  for (std::size_t k = 0; k < terms; ++k) {
    slow[k] = value_of(model.terms[k].slow, now.channels, now.calls);
    if (datum) at_zero[k] = datum->term_values[k];
    coefficients[model.terms[k].basis] += slow[k] * model.terms[k].coefficient;
    coefficients[0] -= at_zero[k] * model.terms[k].coefficient;
    if (model.terms[k].slow.powers.empty() && model.terms[k].slow.calls.empty()) continue;
    const Wide reference = datum ? 0 : value_of(model.terms[k].slow, now.middle, now.middle_calls);
    thermal[model.terms[k].basis] += (slow[k] - reference) * model.terms[k].coefficient;
    thermal[0] -= at_zero[k] * model.terms[k].coefficient;
  }
  for (const Wide value : coefficients)
    out.coefficients_mm.push_back(static_cast<double>(value * model.mm_per_unit));
  if (datum) out.coefficients_mm[0] += datum->q_mm;
  for (const Wide value : thermal)
    out.thermal_mm.push_back(static_cast<double>(value * model.mm_per_unit));

  // A declared error that moved the fit: its shift, folded like the coefficients.
  const auto folded = [&](const auto& shift, bool less_zero) {
    std::vector<Wide> root(size, 0);
    for (std::size_t k = 0; k < terms; ++k) {
      const Wide c = shift[static_cast<Eigen::Index>(k)];
      root[model.terms[k].basis] += slow[k] * c;
      if (less_zero) root[0] -= at_zero[k] * c;
    }
    return root;
  };
  const auto line_of = [&](UncertaintySource source) -> Snapshot::UncertaintyLine& {
    for (auto& line : out.lines)
      if (line.source == source) return line;
    return out.lines.emplace_back(Snapshot::UncertaintyLine{source, {}});
  };
  const auto add_root = [&](UncertaintySource source, std::size_t number,
                            const std::vector<Wide>& root, Wide u) {
    if (u == 0) return;
    auto& line = line_of(source);
    for (const Wide value : root)
      line.roots_nm.push_back(static_cast<double>(value * u * nm_per_unit));
    line.errors.push_back(static_cast<std::uint32_t>(number));
  };

  // The fit's own: the root of its covariance, which needs the digits that the coefficients need.
  // In the model's own datum the zero's reading is a draw of the noise that the rows have: what
  // they share counts once, with the reading.
  const Eigen::MatrixXd& of_fit = datum ? model.root : model.root_beside_zero;
  if (of_fit.size() > 0) {
    auto& line = line_of(UncertaintySource::fit);
    for (Eigen::Index column = 0; column < of_fit.cols(); ++column)
      for (const Wide value : folded(of_fit.col(column), datum != nullptr))
        line.roots_nm.push_back(static_cast<double>(value * nm_per_unit));
  } else {
    out.lines.push_back({UncertaintySource::fit, form_of(index, slow, at_zero)});
  }

  // The robot's own at the zero of a carried datum is not that at the pose.
  const double zeros = datum ? 2.0 : 1.0;
  out.lines.push_back(
      {UncertaintySource::residual, {model.unfollowed_nm * model.unfollowed_nm * zeros}});

  // A thermometer's own error was there when the model was fitted: what the coefficients took up of
  // it comes back with the opposite sign (only the constant, where the term is linear). And it is
  // the same now and at the datum's zero. What makes up for a stale or missing value is neither.
  line_of(UncertaintySource::temperatures);
  for (std::size_t j = 0; j < now.channels.size(); ++j) {
    std::vector<Wide> slope(size, 0);
    Wide slope_at_zero = 0;
    for (std::size_t k = 0; k < terms; ++k) {
      const Wide c = model.terms[k].coefficient;
      slope[model.terms[k].basis] +=
          c * static_cast<Wide>(
                  derivative_of(model.terms[k].slow, j, now.channels, now.calls, now.call_slopes));
      if (datum) slope_at_zero += c * static_cast<Wide>(datum->term_slopes[j][k]);
    }
    add_root(UncertaintySource::temperatures, 2 * j, slope, now.u_independent[j]);
    slope[0] -= slope_at_zero;
    if (model.absorbed[j].size() > 0) {
      const auto back = folded(model.absorbed[j], datum != nullptr);
      for (std::size_t m = 0; m < size; ++m) slope[m] -= back[m];
    }
    add_root(UncertaintySource::temperatures, 2 * j + 1, slope, now.u_systematic[j]);
  }
  // Readings began while an effect with memory still had to do with what was before: one unknown
  // past, now and at the zero.
  for (std::size_t i = 0; i < now.call_shifts.size(); ++i) {
    std::vector<Wide> root(size, 0);
    for (std::size_t k = 0; k < terms; ++k) {
      const Wide c = model.terms[k].coefficient;
      root[model.terms[k].basis] +=
          c * static_cast<Wide>(now.call_shifts[i]) *
          derivative_by_call(model.terms[k].slow, i, now.channels, now.calls);
      if (datum) root[0] -= c * static_cast<Wide>(datum->term_shifts[i][k]);
    }
    const bool any = std::ranges::any_of(root, [](Wide value) { return value != 0; });
    add_root(UncertaintySource::temperatures, 2 * now.channels.size() + i, root, any ? 1 : 0);
  }
  for (const auto& error : model.systematics) {
    auto root = folded(error.shift, datum != nullptr && error.shared_with_zero);
    if (!datum && error.in_rows.size() > 0) {
      const auto in_rows = folded(error.in_rows, false);
      for (std::size_t m = 0; m < size; ++m) root[m] -= in_rows[m];
    }
    add_root(error.source, error.number, root, 1);
  }
  // A carried datum adds the reading of its own zero.
  out.lines.push_back({UncertaintySource::scale, {model.u_scale_nm * model.u_scale_nm * zeros}});

  sum_lines(size, out);
  return out;
}

}  // namespace driftwise::compensation
