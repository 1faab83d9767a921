#pragma once
// Tail probabilities of the t and F distributions, by Boost.Math, good to the smallest double (then
// 0). Ranking never uses them: it goes by |t| (NUMERICS.md section 1).

namespace driftwise::calibration {

double t_two_sided_p(double t, double dof);            // P(|T| > |t|); 1 for NaN, 0 for infinity
double f_upper_p(double f, double dof1, double dof2);  // P(F > f)
double f_quantile(double probability, double dof1, double dof2);  // f with P(F < f) = probability
double t_quantile(double probability, double dof);                // t with P(T < t) = probability

}  // namespace driftwise::calibration
