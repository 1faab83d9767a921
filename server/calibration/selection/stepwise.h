#pragma once
// Stepwise regression, one change at a time, by one of two rules.
//
// Criterion p, the exact rule of NUMERICS.md section 1 (MATLAB stepwisefit, which the published
// study used):
//   1 fit; 2 if any candidate outside has p < p_enter, add the one with the largest |t| and repeat
//   2; 3 only when nothing can enter: if any term inside has p > p_remove, remove the one with the
//   smallest |t| and go to 2; else stop. Strict inequalities. Terms rank by |t|, for p underflows;
//   F within 1e-9 of each other are a tie, which the lowest column wins. Out: F(1, n-k-1) with k
//   columns in, the constant counted; in: F(1, n-k).
// Criteria bic and aic, R's step(direction = "both"): of all single changes, a removal or an
//   addition, make the one that gives the lowest value, as long as that is lower by more than 1e-7;
//   else stop. Values within 1e-9 n of each other are a tie: a removal goes before an addition,
//   then the lowest column wins.
//
// With hierarchy a candidate may enter only when all its parents are in, and a term may leave only
// when it is no parent of a term in; what else would be done stays the same.

#include <string>
#include <vector>

#include "server/calibration/linear/orthogonal_set.h"
#include "server/calibration/linear/triangle.h"
#include "server/calibration/model/criterion.h"

namespace driftwise::calibration {

struct SelectionRule {
  bool stepwise = true;                    // false: every column enters, none is tested
  double p_enter = 0.05, p_remove = 0.10;  // p_remove >= p_enter
  Criterion criterion = Criterion::p;
  std::vector<std::vector<int>> parents;  // hierarchy: per column; empty: none is asked for
  std::vector<char> barred;               // per column: may never enter; empty: none
  // Per output and column: left out of this output, whatever else is said of the column; empty:
  // none is.
  std::vector<std::vector<char>> left_out;
  int starts = 1;  // see starts.h
  std::int64_t seed = 1;

  bool leaves_out(Eigen::Index output, int column) const {
    return !left_out.empty() &&
           left_out[static_cast<std::size_t>(output)][static_cast<std::size_t>(column)] != 0;
  }
};

struct SelectionRecord {
  char action = 's';  // 's'tart 'e'nter 'r'emove
  int column = -1;
  double p = 1, rmse = 0;
  int dof = 0;
  std::optional<double> value;  // of BIC or AIC after the step, where that is the criterion
};

struct Selection {
  OrthogonalSet set;                     // the columns in, and everything about those outside
  std::vector<SelectionRecord> history;  // the start first (column -1)
  std::vector<int>
      unestimable;      // columns that had to be in and are not: nothing left of them in these rows
  bool exact = false;   // stopped because nothing but rounding is left to explain
  bool cycled = false;  // stopped because it kept changing its mind
};

// always[j]: column j is in from the start and never removed. output: which of the triangle's.
// from: columns in at the start besides, which may leave; what cannot be estimated of them, or
// would leave no degree of freedom, stays out. triangle outlives the result.
Selection select(const Triangle& triangle, const Basis& basis, const std::vector<char>& always,
                 Eigen::Index output, const SelectionRule& rule, const std::vector<int>& from = {});

}  // namespace driftwise::calibration
