#pragma once
// The present simulation's columns under one shape of noise: everything that asks "what is left
// beyond them" does so here.
//
// Free coefficients are projected out. Coefficients with a prior N(0, s^2) are integrated out: the
// covariance of the whitened rows is then I + B S B', and project() multiplies by its inverse
// square root, so that squared lengths and products of projected columns are those of the marginal
// likelihood.

#include <Eigen/Core>
#include <vector>

#include "server/diagnosis/noise/noise_model.h"
#include "server/diagnosis/noise/soft_base.h"

namespace driftwise::diagnosis {

class WhitenedSpace {
 public:
  // base: its free columns independent (see independent_base()). output: whose spread it is.
  WhitenedSpace(const Timeline& timeline, NoiseShape shape, const SoftBase& base,
                Eigen::Index output = 0);

  const NoiseShape& shape() const { return shape_; }
  Eigen::Index dof() const { return basis_.rows() - free_; }

  void whiten(Eigen::Ref<Eigen::MatrixXd> columns) const { whitener_.apply(columns); }
  // Whitened columns freed of what the base explains.
  void project(Eigen::Ref<Eigen::MatrixXd> white) const;
  Eigen::MatrixXd left_over(Eigen::MatrixXd columns) const;  // both
  // Products of whitened columns, each freed of what the base explains: those of project().
  Eigen::MatrixXd gram_beyond(const Eigen::MatrixXd& white) const;
  // Twice the negative restricted log-likelihood of the shape, up to a constant that all shapes
  // share. rss: of left_over().
  double criterion(double rss) const;

 private:
  NoiseShape shape_;
  Whitener whitener_;
  Eigen::MatrixXd basis_;    // orthonormal: of the free columns, then of the others beyond them
  Eigen::VectorXd removed_;  // share of each direction that project() takes away, 0 to 1
  Eigen::Index free_ = 0;
  double log_determinants_ = 0;
};

// The free columns that are not combinations of those before them, each scaled to unit length;
// those with a prior as they are.
SoftBase independent_base(const SoftBase& base);

}  // namespace driftwise::diagnosis
