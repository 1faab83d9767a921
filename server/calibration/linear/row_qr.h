#pragma once
// The triangle of a tall matrix: R of a Householder QR, by blocks of rows (TSQR). Q is never
// formed.

#include <Eigen/Core>
#include <vector>

namespace driftwise::calibration {

// R of all rows added so far: min(rows, width) x width, upper trapezoid; R'R = rows' rows. Backward
// stable whatever the rows (Demmel, Grigori, Hoemmen and Langou 2012). Cost 2 rows width^2.
class GrowingTriangle {
 public:
  explicit GrowingTriangle(Eigen::Index width) : triangle_(0, width) {}

  // rows: tall::padded(count) x width, the first count of them meant; they are overwritten.
  void add(Eigen::MatrixXd& rows, Eigen::Index count);
  const Eigen::MatrixXd& triangle() const { return triangle_; }

 private:
  Eigen::MatrixXd triangle_;
};

// Rows that a block may have to stay in a core's second-level cache while many columns pass over
// them; a multiple of tall::kLanes.
Eigen::Index block_rows(Eigen::Index width);

// Of a matrix that is there.
Eigen::MatrixXd row_qr(const Eigen::Ref<const Eigen::MatrixXd>& matrix);

// The triangle of all rows together, given those of its parts.
Eigen::MatrixXd join_triangles(const std::vector<Eigen::MatrixXd>& triangles);

}  // namespace driftwise::calibration
