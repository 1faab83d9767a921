#pragma once
// A growing set of columns kept orthogonal by Householder reflections: what stepwise selection
// works on.
//
// columns: r x p raw columns (small, from the triangle); y: r; beyond: |y|^2 outside their space;
// rows: of the data. Cost of entering or removing: O(r p).

#include <Eigen/Core>
#include <span>
#include <vector>

namespace driftwise::calibration {

struct TermStatistics {
  double coefficient = 0, standard_error = 0, t = 0;
  bool estimable = false;  // false: collinear with the terms in, or no degrees of freedom left
  double f() const { return t * t; }
};

class OrthogonalSet {
 public:
  // own_norms[j]: the norm that rounding of column j is compared with besides the column's own:
  // |value * monomial| of its highest part. See collinear().
  OrthogonalSet(const Eigen::MatrixXd& columns, const Eigen::Ref<const Eigen::VectorXd>& y,
                double beyond, std::int64_t rows, const Eigen::VectorXd& own_norms);

  void enter(int column);
  // The column becomes a candidate again; Givens rotations put the rest back into a triangle.
  void remove(int column);

  bool has(int column) const;
  const std::vector<int>& order() const { return order_; }  // as entered
  std::int64_t rows() const { return rows_; }
  int dof() const { return static_cast<int>(rows_ - static_cast<std::int64_t>(order_.size())); }
  double rss() const { return rss_; }
  double total() const { return total_; }  // |y|^2
  double rmse() const;

  // What is left of a column beyond those in is below 1e-7 of it: R's tolerance (lm, tol = 1e-7). A
  // product or power far from zero is nearly a lower power by nature; for those 1e-7 of its own
  // part counts, which is still well measured.
  bool collinear(int column) const;

  // As if the column alone were added to those in.
  TermStatistics outside(int column) const;
  // Of those in, in order().
  std::vector<TermStatistics> inside() const;
  // Weights of the columns in, in order(), that reproduce a column; for naming what it equals.
  Eigen::VectorXd reproduced_by_set(int column) const;
  double norm(int column) const { return norms_[column]; }
  double left_over(int column) const;  // norm of what is left of the column beyond those in

 private:
  void reset();
  Eigen::Index depth() const { return static_cast<Eigen::Index>(order_.size()); }
  void update_rss();

  const Eigen::MatrixXd& columns_;
  Eigen::VectorXd y_;
  double beyond_, total_, rss_ = 0;
  std::int64_t rows_;
  Eigen::VectorXd own_norms_, norms_;
  Eigen::MatrixXd work_;  // columns and y, reflected
  std::vector<int> order_;
};

}  // namespace driftwise::calibration
