#pragma once
// Rows to learn from that a diagnosis needs beyond the terms of its baseline.

#include <cstddef>
#include <string>
#include <vector>

#include "server/calibration/model/fit_options.h"
#include "server/core/data/dataset.h"
#include "server/core/result.h"
#include "server/diagnosis/rows/screen.h"

namespace driftwise::diagnosis {

struct Problem;

inline constexpr std::size_t kRowsBeyondBase = 10;

// problem: with its terms, outputs, learn and judge.
// Error: invalid_argument TOO_FEW_ROWS, which says where the other rows are: left out, marked
// validation, without a value of which channel; and what to do.
Result<void> check_rows_needed(const Problem& problem);

// Rows that neither learn nor judge: they lack a value of the baseline or of an output, or are of a
// datum that no row teaches. A sentence for each of the two; none where there are none.
std::vector<std::string> rows_left_out(const Problem& problem);

struct LivingBaseline {
  calibration::Candidates baseline;
  std::vector<std::string> dead;  // symbols that nothing may read
};

// Rows in which a thermometer of the baseline is frozen teach nothing while enough others are left
// for each term. Else it is dead: the baseline loses it, and what the robot does with it is left to
// whatever looks like it. One that the baseline does not read is dead when it is frozen in more
// rows than a cause is worth.
LivingBaseline without_dead_sensors(const calibration::Candidates& baseline, const Dataset& dataset,
                                    const std::vector<FaultySensor>& sensors);

}  // namespace driftwise::diagnosis
