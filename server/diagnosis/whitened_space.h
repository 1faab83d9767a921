#pragma once
// The present simulation's columns under one shape of noise: everything that asks "what is left
// beyond them" does so here.

#include <Eigen/Core>
#include <vector>

#include "server/diagnosis/noise_model.h"

namespace driftwise::diagnosis {

class WhitenedSpace {
 public:
  // base: rows x k, independent columns (see independent_columns()).
  WhitenedSpace(const Timeline& timeline, NoiseShape shape, const Eigen::MatrixXd& base);

  const NoiseShape& shape() const { return shape_; }
  Eigen::Index dof() const { return basis_.rows() - basis_.cols(); }

  void whiten(Eigen::Ref<Eigen::MatrixXd> columns) const { whitener_.apply(columns); }
  // Whitened columns freed of what the base explains.
  void project(Eigen::Ref<Eigen::MatrixXd> white) const;
  Eigen::MatrixXd left_over(Eigen::MatrixXd columns) const;  // both
  // Twice the negative restricted log-likelihood of the shape, up to a constant that all shapes
  // share. rss: of left_over().
  double criterion(double rss) const;

 private:
  NoiseShape shape_;
  Whitener whitener_;
  Eigen::MatrixXd basis_;  // orthonormal
  double log_determinants_ = 0;
};

// The columns that are not combinations of those before them, each scaled to unit length.
Eigen::MatrixXd independent_columns(const Eigen::MatrixXd& columns);

}  // namespace driftwise::diagnosis
