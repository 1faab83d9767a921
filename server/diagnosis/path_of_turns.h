#pragma once
// Did the axis go past its target where the file has the same place twice at a turn? The file does
// not say so, a play on either path does.

#include <string>
#include <vector>

#include "server/diagnosis/answer/diagnosis.h"
#include "server/diagnosis/rows/problem.h"

namespace driftwise::diagnosis {

// lay_out(). Where the file does not say it itself, and the baseline and a play leave far less with
// those turns in the path than without them, the data say so from here on (core/data/overruns.h),
// and a sentence tells the user.
Result<Problem> lay_out_on_path(Dataset& data, const DiagnoseOptions& options, std::size_t longest,
                                Judging judging, std::vector<std::string>& sentences);

}  // namespace driftwise::diagnosis
