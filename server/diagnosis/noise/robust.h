#pragma once
// Middles and spreads that a few wrong values do not move.

#include <vector>

namespace driftwise::diagnosis {

// 0 of nothing; of an even count the upper of the two in the middle.
double median(std::vector<double> values);
// The standard deviation that normal values about zero with this median of |value| have.
double robust_sd(std::vector<double> values);

// Student's law about zero, by maximum likelihood over scale and degrees of freedom (2 to 1000).
struct StudentLaw {
  double scale = 0, freedom = 1000;
  // Chance of a value at least as far from zero. 0 scale: 0.
  double beyond(double value) const;
};
// least: of the scale, such as the resolution of the values.
StudentLaw student_law(const std::vector<double>& values, double least);
// Chance that `count` or more of `all` independent values have a property of chance p: at most the
// expected number of such groups.
double chance_of_as_many(double p, std::size_t count, std::size_t all);

}  // namespace driftwise::diagnosis
