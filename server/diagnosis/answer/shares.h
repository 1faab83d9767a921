#pragma once
// What a discrepancy goes with, variable by variable: the first look of a diagnosis, which names no
// cause.

#include <string>
#include <vector>

namespace driftwise::diagnosis {

struct Share {
  std::string variable;  // "x", "t07", "time"
  double share = 0;      // R^2 of the discrepancy on 1, v, v^2 alone: 0 .. 1
};

// R^2 of y on 1, v, v^2 over the rows where both are finite: 0 .. 1; 0 below 4 rows or without
// variation.
double marginal_share(const std::vector<double>& variable, const std::vector<double>& y);

}  // namespace driftwise::diagnosis
