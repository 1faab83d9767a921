#pragma once
// What runs state at the head of their data ("# parts:", "# measured_by:", "# overruns:"), taken
// together: the rows of several runs have one head, and a computation reads what stands there.

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "server/core/data/dataset.h"
#include "server/core/ids.h"
#include "server/core/result.h"

namespace driftwise {

inline constexpr const char* kLeftOutKey = "left_out";  // "measured_by of x: not stated by run 12"

struct StatedLines {
  std::vector<RunId> runs;                                 // at least one, whose rows these are
  std::vector<std::pair<std::string, std::string>> lines;  // others than the three do not count
};

// data: the rows of all of them; data.run says whose each is (empty: there is one run). A part is
// kept where one of the runs that have the channel states it. An instrument is kept where each run
// that has the coordinate states it, weighted by their rows; else a line kLeftOutKey says which run
// does not. Errors: invalid_argument METADATA_DISAGREE, naming runs and values: overruns in one run
// and not in another, two parts of one channel.
Result<std::vector<std::pair<std::string, std::string>>> stated_together(
    const Dataset& data, std::span<const StatedLines> sources);

}  // namespace driftwise
