#pragma once
// Middles and spreads that a few wrong values do not move.

#include <array>
#include <cstddef>
#include <vector>

namespace driftwise::diagnosis {

// 0 of nothing; of an even count the upper of the two in the middle.
double median(std::vector<double> values);
// The standard deviation that normal values about zero with this median of |value| have.
double robust_sd(std::vector<double> values);

// Student's law about zero for each of some degrees of freedom (2 to 1000), its scale by maximum
// likelihood. How heavy the tail is a few hundred values tell only roughly: what is asked of it is
// the average over the laws, each by how likely the values are under it.
class StudentLaw {
 public:
  static constexpr std::array<double, 7> kFreedoms = {2, 3, 4, 6, 10, 20, 1000};
  // Chance of a value at least as far from zero. 0 where all values are.
  double beyond(double value) const;

 private:
  friend StudentLaw student_law(const std::vector<double>& values, double least);
  std::array<double, kFreedoms.size()> scale_{}, weight_{};
};
// least: of the scale, such as the resolution of the values.
StudentLaw student_law(const std::vector<double>& values, double least);
// Chance that `count` or more of `all` independent values have a property of chance p: at most the
// expected number of such groups.
double chance_of_as_many(double p, std::size_t count, std::size_t all);

}  // namespace driftwise::diagnosis
