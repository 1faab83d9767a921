#pragma once
// The design of a fit: which rows, which columns, and on demand any rows of the matrix [1 | U | Y]
// of monomials in scaled coordinates.

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "server/calibration/design/basis.h"
#include "server/calibration/design/design_columns.h"
#include "server/calibration/model/fit_options.h"
#include "server/core/data/dataset.h"
#include "server/core/result.h"

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
  DesignColumns columns;          // about their means over some of the rows
  bool weighted = false;
  std::vector<int> datum;       // per row: ordinal of its datum, from 1
  std::int64_t dropped = 0;     // calibration and validation rows with a missing value
  std::int64_t validation = 0;  // complete rows marked validation
  std::int64_t excluded = 0;    // of either set: looked at by nothing but effects with memory

  Eigen::Index monomials() const { return static_cast<Eigen::Index>(basis.monomials.size()); }
  Eigen::Index row_count() const { return static_cast<Eigen::Index>(rows.size()); }
  Eigen::Index width() const { return columns.width(); }  // monomials, then outputs
  // Rows [begin, begin + count) of the matrix. Any thread.
  Eigen::MatrixXd block(Eigen::Index begin, Eigen::Index count) const;
  // The same, into rows that are there already.
  void fill(Eigen::Index begin, Eigen::Ref<Eigen::MatrixXd> out) const;
};

// The dataset outlives the design. Errors: see fit().
Result<Design> make_design(const Dataset& dataset, const FitOptions& options);

// Ordinal of each row's datum: 1, 2, ... in order of appearance. Rows of another run are another
// datum.
std::vector<double> datum_ordinals(const Dataset& dataset);

}  // namespace driftwise::calibration
