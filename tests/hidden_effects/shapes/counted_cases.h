#pragma once
// A sweep's cases judged with few nulls, as a test can afford them.

#include "tests/hidden_effects/shapes/sweep_plan.h"

namespace driftwise::hidden {

struct CountedCases {
  Rate in_set;      // named, or in the reported set, and nothing else
  Rate false_name;  // something else was named
};

// 99 nulls; prints what was not exact. Throws as judged() does.
CountedCases counted(const SweepPlan& plan);

}  // namespace driftwise::hidden
