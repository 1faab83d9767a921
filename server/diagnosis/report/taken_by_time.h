#pragma once
// "Adequate" means that no cause is told from noise. Where slow noise has most of what is left, a
// drift may be in it: the report says how much goes with the time, and what would tell.

#include <string>
#include <vector>

#include "server/diagnosis/answer/diagnosis.h"

namespace driftwise::diagnosis {

// One sentence per output on which no finding acts, of which four fifths of the variance go with
// the time (a parabola) and the white noise is less than half as large.
std::vector<std::string> taken_by_time(const Diagnosis& diagnosis);

}  // namespace driftwise::diagnosis
