#pragma once
// What no machine does: a cause whose coefficients would have to be larger than its physics allow
// is not the cause.
//
//   thermal_expansion  30 ppm/K of what a sensor sees: no material of machines grows more
//   abbe_offset        what the cell declares of its beams (lever_limits.h); unlimited without
//
// Limits are of pose axes; on a motor they count with the slopes of the motor over the pose.
//
// And what tilts do must be told from geometry: a robot that tilts where it goes carries the shape
// of its tilts over the workspace, and a lever on them is a polynomial of the pose. Only what tilts
// do beyond such a polynomial (under force, with heat) speaks for the lever.

#include <Eigen/Core>
#include <optional>

#include "server/diagnosis/cause.h"
#include "server/diagnosis/ground.h"
#include "server/diagnosis/lever_limits.h"
#include "server/diagnosis/problem.h"

namespace driftwise::diagnosis {

class Plausibility {
 public:
  // problem outlives it.
  Plausibility(const Problem& problem, const std::optional<LeverLimits>& levers);

  // columns: of `terms`, one row per block; shape: of the noise, per output (Gain::shape). False
  // where a coefficient is beyond its limit by more than twice its standard error.
  bool allows(const Cause& cause, const std::vector<effects::Term>& terms,
              const Eigen::MatrixXd& columns, const std::vector<std::size_t>& shape,
              const Ground& ground) const;
  // Does at least half of what the columns of a lever on tilts explain stay when geometry is free?
  // True for every other cause.
  bool told_from_geometry(const Cause& cause, const Eigen::MatrixXd& columns,
                          const std::vector<std::size_t>& shape, const Ground& ground) const;

 private:
  // Are there limits to what this cause can do?
  bool limits(const Cause& cause) const;
  // Largest coefficient of a term of the cause on an output, nm per unit of the term.
  double largest(const Cause& cause, const effects::Term& term, std::size_t output) const;

  const Problem& problem_;
  std::optional<LeverLimits> levers_;
  Eigen::MatrixXd slopes_;    // outputs x 3, nm per mm of x y z; 0 where an axis does not vary
  Eigen::MatrixXd geometry_;  // blocks x monomials of the pose
};

}  // namespace driftwise::diagnosis
