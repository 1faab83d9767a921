#pragma once
// Files that have a place under one name only: deviations beside the positions that were commanded
// ("ex ~ q1"), or beside nominal positions ("ex ~ x") without a motor's. A place is both, the path
// of a motor and the pose that geometry, heat and waves go with, so the other name stands in while
// causes are sought. What is found has the file's own names.

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/diagnosis/answer/diagnosis.h"

namespace driftwise::diagnosis {

// Lengths of the pose that are no coordinate of a machine: how far it strays from a line, beside an
// axis a thousand times as long ("y ~ x", straightness). They were measured, like the output, and
// no cause may read them. An output, or what the baseline does not read and does not repeat.
std::vector<std::string> deviations_of(const Dataset& dataset,
                                       const calibration::Candidates& baseline);

struct StandIns {
  Dataset data;             // with the columns that stand in
  DiagnoseOptions options;  // the baseline reads the pose where it read a motor's place
  std::vector<std::pair<std::string, std::string>> names;  // that stands in, the file's own
};

// Nothing where the file has both, or neither: pose coordinates that are outputs or do not repeat
// are measured, more than three lengths or one angle are no axes of a machine. Where a motor's
// place is the output its pose is missing, not named otherwise.
std::optional<StandIns> stand_ins(const Dataset& dataset, const DiagnoseOptions& options);

// The findings, sentences and formulas with the file's own names.
void name_as_in_file(const StandIns& stand_ins, Diagnosis& diagnosis);

}  // namespace driftwise::diagnosis
