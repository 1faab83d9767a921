#pragma once
// The last word belongs to rows that took no part: a cause with which they are described clearly
// worse than without it does not stand, however well it does on the rows it was found in. Nine
// places of calibration can be joined by anything; what lies between them tells.

#include <string>
#include <vector>

#include "server/diagnosis/extension.h"

namespace driftwise::diagnosis {

// Takes back what harms, the worst first, until nothing does; a sentence for each. Jumps are left
// alone: they are events, and blocks of time held out may lie on one side of them. With fewer than
// 20 judging rows nothing is judged.
std::vector<std::string> withdraw_what_harms(const Problem& problem,
                                             const std::vector<Cause>& causes,
                                             Extension& extension);

}  // namespace driftwise::diagnosis
