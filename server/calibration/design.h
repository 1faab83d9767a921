#pragma once
// The design of a fit: which rows, which columns, and the matrix [1 | U | Y] of monomials in scaled
// coordinates.

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "server/calibration/basis.h"
#include "server/calibration/fit.h"

namespace driftwise::calibration {

struct Design {
  std::vector<Channel> outputs;
  std::vector<effects::Term>
      terms;  // the constant first where there is one, then datum constants, then the candidates
  std::vector<char>
      always;  // per term: in from the start, never removed (the constant, datum(k), forced)
  bool constant = true;  // terms[0] is the constant

  std::vector<Variable> variables;
  Basis basis;                    // expansions: one per term
  std::vector<std::size_t> rows;  // of the dataset: complete calibration rows, in order
  Eigen::MatrixXd matrix;  // rows x (monomials + outputs), each row times the root of its weight
  Eigen::VectorXd means;  // of the columns of matrix, which stand about them (the constant's is 0):
                          // y of 60 000 +- 3 000 would otherwise cost a digit
  bool weighted = false;
  std::vector<int> datum;       // per row: ordinal of its datum, from 1
  std::int64_t dropped = 0;     // calibration and validation rows with a missing value
  std::int64_t validation = 0;  // complete rows marked validation
  std::int64_t excluded = 0;    // of either set: looked at by nothing but effects with memory

  Eigen::Index monomials() const { return static_cast<Eigen::Index>(basis.monomials.size()); }
};

// Errors: see fit().
Result<Design> make_design(const Dataset& dataset, const FitOptions& options);

// Ordinal of each row's datum: 1, 2, ... in order of appearance. Rows of another run are another
// datum.
std::vector<double> datum_ordinals(const Dataset& dataset);

}  // namespace driftwise::calibration
