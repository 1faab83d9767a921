#include "server/calibration/linear/tail.h"

#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <boost/math/special_functions/beta.hpp>
#include <cmath>

namespace driftwise::calibration {
namespace {

namespace policies = boost::math::policies;
// No promotion to long double: 1e-13 is plenty for a p-value, and selection waits for it.
using Policy = policies::policy<policies::promote_double<false>,
                                policies::underflow_error<policies::ignore_error>,
                                policies::overflow_error<policies::ignore_error>,
                                policies::evaluation_error<policies::ignore_error>>;

}  // namespace

double f_upper_p(double f, double dof1, double dof2) {
  if (std::isnan(f) || f <= 0 || dof1 <= 0 || dof2 <= 0) return 1;
  if (std::isinf(f)) return 0;
  // Of x and 1 - x the smaller one is given, so that no digits are lost in either tail.
  const double numerator = dof1 * f;
  if (std::isinf(numerator)) return 0;
  if (numerator > dof2)
    return boost::math::ibeta(dof2 / 2, dof1 / 2, dof2 / (dof2 + numerator), Policy());
  return boost::math::ibetac(dof1 / 2, dof2 / 2, numerator / (dof2 + numerator), Policy());
}

double t_two_sided_p(double t, double dof) { return f_upper_p(t * t, 1, dof); }

double f_quantile(double probability, double dof1, double dof2) {
  return boost::math::quantile(boost::math::fisher_f(dof1, dof2), probability);
}

double t_quantile(double probability, double dof) {
  return boost::math::quantile(boost::math::students_t(dof), probability);
}

}  // namespace driftwise::calibration
