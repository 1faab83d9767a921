#pragma once
// How often chance does as well, after the search over parameters and causes: from series simulated
// with the fitted noise and pushed through the same scan, extended into the tail by its known
// shape.

#include <cstddef>
#include <vector>

namespace driftwise::diagnosis {

// ln P(X > x) of chi-squared with this many degrees of freedom, far into the tail.
double ln_chi2_upper(double x, double dof);

// What one more degree of freedom is worth where causes of different size compete: the chi-squared
// that chance exceeds once in ten thousand. Cells of one cause are compared by gain less this.
double price_of(int dof);

// The best gain of one cause over its cells behaves in the tail like the largest of N independent
// chi-squared variables, stretched by a scale where the noise is not known exactly. Both are fitted
// to the nulls' gains by maximum likelihood: 1 <= N <= cells, and a scale that is held to 1 as by
// fifty nulls more (it is 1 in theory, and one estimated from a few nulls is a poor guide).
class NullTail {
 public:
  NullTail() = default;
  NullTail(const std::vector<double>& null_gains, int dof, std::size_t cells);
  double ln_p(double gain) const;  // of one look at this cause

 private:
  int dof_ = 1;
  double ln_cells_ = 0, scale_ = 1;
};

// The same once more over the causes: from each null series' smallest ln p.
class SearchTail {
 public:
  SearchTail(const std::vector<double>& null_smallest_ln_p, std::size_t causes);
  double adjusted_p(double smallest_ln_p) const;

 private:
  double ln_causes_ = 0;
};

}  // namespace driftwise::diagnosis
