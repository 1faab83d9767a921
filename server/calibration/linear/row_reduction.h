#pragma once
// The rows of a design reduced to small matrices, one per piece of consecutive rows. The triangle
// of any set of pieces then costs their number times width^3 and never goes back to the rows: the
// fit takes all pieces, a held-out fold all but some.
//
// Two ways. qr: R of each piece by Householder reflections, as accurate as double precision gets.
// gram: X'X of each piece, some times faster on many rows, taken only while every scaled pivot
// (what is left of a column beyond those before it, as a part of its sum of squares) stays above
// kSafePivot. So that y does not lose digits to X'X, its columns stand about a preliminary solution
// from some of the rows. NUMERICS.md section 2.
//
// Pieces are cut into units of a fixed number of rows, each worked on by one thread and joined in
// their order: the result is the same to the last bit for every executor.

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "server/calibration/design/design.h"
#include "server/calibration/linear/triangle.h"
#include "server/calibration/model/executor.h"
#include "server/calibration/model/solver.h"

namespace driftwise::calibration {

class RowReduction {
 public:
  // cuts: 0, the first row of each further piece ascending, the number of rows. design outlives
  // this. wanted: automatic takes gram where the rows are many; gram tries it on any number.
  RowReduction(const Design& design, std::vector<Eigen::Index> cuts, Solver wanted,
               const Executor& executor);

  const std::vector<Eigen::Index>& cuts() const { return cuts_; }
  std::size_t pieces() const { return cuts_.size() - 1; }

  // Of the rows of these pieces together, ascending. None: the gram of these pieces is not safe.
  std::optional<Triangle> triangle(const std::vector<std::size_t>& pieces) const;
  Triangle all() const;

  Solver solver() const { return solver_; }          // the one taken: gram or qr
  const std::string& note() const { return note_; }  // why gram was wanted and not taken; else ""

 private:
  void reduce(const Executor& executor);
  Eigen::MatrixXd join(const std::vector<Eigen::MatrixXd>& parts) const;
  std::string why_not_gram() const;  // "" where all pieces together are safe

  const Design& design_;
  std::vector<Eigen::Index> cuts_;
  Solver solver_ = Solver::qr;
  std::string note_;
  Eigen::MatrixXd preliminary_;         // monomials x outputs; gram only
  std::vector<Eigen::MatrixXd> parts_;  // per piece: R, or the lower triangle of X'X
};

}  // namespace driftwise::calibration
