#pragma once
// What tilts do must be told from geometry: a robot that tilts where it goes carries the shape of
// its tilts over the workspace, and a lever on them is a polynomial of the pose. Only what tilts do
// beyond such a polynomial (under force, with heat) speaks for the lever.

#include <Eigen/Core>

#include "server/diagnosis/catalogue/cause.h"
#include "server/diagnosis/noise/ground.h"
#include "server/diagnosis/rows/problem.h"

namespace driftwise::diagnosis {

class ToldFromGeometry {
 public:
  explicit ToldFromGeometry(const Problem& problem);

  // columns: of the cause, one row per block; shape: of the noise, per output (Gain::shape). Does
  // at least half of what the columns of a lever on tilts explain stay when geometry is free? True
  // for every other cause.
  bool operator()(const Cause& cause, const Eigen::MatrixXd& columns,
                  const std::vector<std::size_t>& shape, const Ground& ground) const;

 private:
  Eigen::MatrixXd geometry_;  // blocks x monomials of the pose
};

}  // namespace driftwise::diagnosis
