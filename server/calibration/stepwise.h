#pragma once
// Stepwise regression by the exact rule of NUMERICS.md section 1 (MATLAB stepwisefit, which the
// published study used).
//
//   1 fit; 2 if any candidate outside has p < p_enter, add the one with the largest |t| and repeat
//   2; 3 only when nothing can enter: if any term inside has p > p_remove, remove the one with the
//   smallest |t| and go to 2; else stop. Strict inequalities. Terms rank by |t|, for p underflows;
//   F within 1e-9 of each other are a tie, which the lowest column wins. Out: F(1, n-k-1) with k
//   columns in, the constant counted; in: F(1, n-k).

#include <string>
#include <vector>

#include "server/calibration/orthogonal_set.h"
#include "server/calibration/triangle.h"

namespace driftwise::calibration {

struct SelectionRule {
  bool stepwise = true;                    // false: every column enters, none is tested
  double p_enter = 0.05, p_remove = 0.10;  // p_remove >= p_enter
};

struct SelectionRecord {
  char action = 's';
  int column = -1;
  double p = 1, rmse = 0;
  int dof = 0;
};  // 's'tart 'e'nter 'r'emove

struct Selection {
  OrthogonalSet set;                     // the columns in, and everything about those outside
  std::vector<SelectionRecord> history;  // the start first (column -1)
  std::vector<int>
      unestimable;      // columns that had to be in and are not: nothing left of them in these rows
  bool exact = false;   // stopped because nothing but rounding is left to explain
  bool cycled = false;  // stopped because it kept changing its mind
};

// always[j]: column j is in from the start and never removed. output: which of the triangle's.
// triangle outlives the result.
Selection select(const Triangle& triangle, const Basis& basis, const std::vector<char>& always,
                 Eigen::Index output, const SelectionRule& rule);

}  // namespace driftwise::calibration
