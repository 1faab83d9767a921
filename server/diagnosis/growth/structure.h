#pragma once
// Structure that no entry of the catalogue explains: does what is left go with a variable, in
// whatever shape?

#include <string>
#include <vector>

#include "server/diagnosis/catalogue/physics.h"
#include "server/diagnosis/rows/problem.h"
#include "server/diagnosis/search/scan.h"

namespace driftwise::diagnosis {

struct FreeShapes {
  std::vector<std::string> variables;  // "x", "t07", "time", "x with time"
  Bank bank;                           // one entry each: hat functions between quantiles
};

// One per channel that varies and time where the rows have it; each axis in proportion, changing
// with time and with each other variable.
FreeShapes free_shapes(const Problem& problem, const Physics& physics,
                       const std::vector<std::string>& excluded);

}  // namespace driftwise::diagnosis
