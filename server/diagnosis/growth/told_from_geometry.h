#pragma once
// What tilts do must be told from geometry: a robot that tilts where it goes carries the shape of
// its tilts over the workspace, and a lever on them is a polynomial of the pose. Only what tilts do
// beyond such a polynomial (under force, with heat) speaks for the lever. A wave, too: 10.00012 um
// along places that are whole multiples of 10 um is one slow turn over 0.8 m, and as smooth as what
// the geometry lacks.

#include <Eigen/Core>

#include "server/diagnosis/catalogue/cause.h"
#include "server/diagnosis/noise/ground.h"
#include "server/diagnosis/rows/problem.h"

namespace driftwise::diagnosis {

class ToldFromGeometry {
 public:
  explicit ToldFromGeometry(const Problem& problem);  // which outlives it

  // columns: of the cause at this parameter, one row per block; shape: of the noise, per output
  // (Gain::shape). Does at least half of what the columns of a lever on tilts explain stay when
  // geometry is free? Has a wave of eight periods or more along a coordinate more than two on
  // these places? True for every other cause.
  bool operator()(const Cause& cause, double parameter, const Eigen::MatrixXd& columns,
                  const std::vector<std::size_t>& shape, const Ground& ground) const;

 private:
  bool turns_on_these_places(const Cause& cause, double period,
                             const Eigen::MatrixXd& columns) const;

  const Problem& problem_;
  Eigen::MatrixXd geometry_;  // blocks x monomials of the pose
};

}  // namespace driftwise::diagnosis
