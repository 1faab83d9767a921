// The algebra of a snapshot: one output's terms folded at the present conditions.
//
// Term k = (slow value s_k) * (basis entry m_k). With a the vector of term values, a = S b, S
// holding s_k in column m_k; anchored, minus the term's value at the datum's zero: S - d e_0'. Then
// q = c'a (+ q at the zero), var q = a' C a, and each slow channel T_j adds u_j^2 (g_j' b)^2 with
// g_j the same fold of the terms' derivatives. Sums in long double: the covariance of a model in
// raw temperatures is the difference of large numbers.

#include <algorithm>

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
  void add_square(const std::vector<Wide>& g, Wide factor) {
    for (std::size_t i = 0; i < size_; ++i)
      for (std::size_t j = 0; j < size_; ++j) add(i, j, factor * g[i] * g[j]);
  }
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

}  // namespace

Snapshot::Output SnapshotBuilder::fold(std::size_t index, const Conditions& now) const {
  const Output& model = outputs_[index];
  const Datum* datum = datum_.empty() ? nullptr : &datum_[index];
  const std::size_t size = basis_.size(), terms = model.terms.size();
  const Wide nm_per_unit = static_cast<Wide>(model.mm_per_unit) * static_cast<Wide>(kNmPerMm);
  Snapshot::Output out;
  out.channel = model.channel;

  std::vector<Wide> slow(terms), at_zero(terms, 0);
  std::vector<Wide> coefficients(size, 0);
  for (std::size_t k = 0; k < terms; ++k) {
    slow[k] = value_of(model.terms[k].slow, now.channels, now.calls);
    if (datum) at_zero[k] = datum->term_values[k];
    coefficients[model.terms[k].basis] += slow[k] * model.terms[k].coefficient;
    coefficients[0] -= at_zero[k] * model.terms[k].coefficient;
  }
  for (const Wide value : coefficients)
    out.coefficients_mm.push_back(static_cast<double>(value * model.mm_per_unit));
  if (datum) out.coefficients_mm[0] += datum->q_mm;

  Form fit(size);
  for (std::size_t k = 0; k < terms; ++k)
    for (std::size_t l = 0; l < terms; ++l) {
      const Wide c = model.covariance(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(l));
      const std::size_t m = model.terms[k].basis, n = model.terms[l].basis;
      fit.add(m, n, c * slow[k] * slow[l]);
      fit.add(m, 0, -c * slow[k] * at_zero[l]);
      fit.add(0, n, -c * at_zero[k] * slow[l]);
      fit.add(0, 0, c * at_zero[k] * at_zero[l]);
    }
  out.lines.push_back({UncertaintySource::fit, fit.packed_nm2(nm_per_unit * nm_per_unit)});

  // A thermometer's own error is the same now and at the datum's zero, so its part there is taken
  // off again; what makes up for a stale or missing value is not.
  Form temperatures(size);
  for (std::size_t j = 0; j < now.channels.size(); ++j) {
    std::vector<Wide> slope(size, 0);
    Wide slope_at_zero = 0;
    for (std::size_t k = 0; k < terms; ++k) {
      const Wide c = model.terms[k].coefficient;
      slope[model.terms[k].basis] +=
          c * static_cast<Wide>(derivative_of(model.terms[k].slow, j, now.channels, now.calls));
      if (datum) slope_at_zero += c * static_cast<Wide>(datum->term_slopes[j][k]);
    }
    temperatures.add_square(slope, static_cast<Wide>(now.u_independent[j]) * now.u_independent[j]);
    slope[0] -= slope_at_zero;
    temperatures.add_square(slope, static_cast<Wide>(now.u_systematic[j]) * now.u_systematic[j]);
  }
  out.lines.push_back(
      {UncertaintySource::temperatures, temperatures.packed_nm2(nm_per_unit * nm_per_unit)});

  // A carried datum adds the noise of its own zero, measured like any point.
  const auto residual_nm = static_cast<double>(nm_per_unit * static_cast<Wide>(model.rmse));
  out.lines.push_back(
      {UncertaintySource::residual, {residual_nm * residual_nm * (datum ? 2.0 : 1.0)}});
  out.lines.push_back({UncertaintySource::scale, {model.u_scale_nm * model.u_scale_nm}});

  out.variance_nm2.assign(packed_size(size), 0.0);
  for (const auto& line : out.lines)
    for (std::size_t i = 0; i < line.variance_nm2.size(); ++i)
      out.variance_nm2[i] += line.variance_nm2[i];
  return out;
}

}  // namespace driftwise::compensation
