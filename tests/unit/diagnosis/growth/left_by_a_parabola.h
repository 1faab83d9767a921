#pragma once
// Omnibus test of an axis that is described by a parabola.

#include <stdexcept>

#include "server/diagnosis/growth/omnibus.h"
#include "server/diagnosis/rows/problem.h"
#include "server/formats/formula/formula.h"

namespace driftwise::diagnosis {

// data: q1 and x in mm, times, and lines where the plan has them; every row is asked.
inline OmnibusResult left_by_a_parabola(const Dataset& data) {
  const auto baseline = formats::Formula::parse("q1 ~ x + x^2")->expand(data);
  const auto problem = lay_out(data, *baseline, kMostSearched);
  if (!problem) throw std::runtime_error(problem.error().message);
  const Eigen::MatrixXd series = problem->series();
  Omnibus omnibus(*problem, series, {});
  return *omnibus.test(SoftBase(problem->learned(problem->base_columns)), {});
}

}  // namespace driftwise::diagnosis
