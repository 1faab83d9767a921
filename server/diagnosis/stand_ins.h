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
  bool replaced = false;                   // the file's own names are not beside them
  std::vector<std::string> nameless = {};  // coordinates that no name of a coordinate was left for
};

// A length or an angle under a name of its own has the role that its place in the baseline gives
// it: an output is a motor's, what is read is the pose's; the other way round where the outputs are
// the pose or a motor is read. The catalogue knows roles by the names q<n>, x, y, z, rx, ry, rz, so
// these stand for the file's own while causes are sought. What is a twentieth of the largest
// coordinate of its kind, or less than a degree beside lengths, is a deviation or a tilt, and keeps
// its name. Nothing where no channel has such a role.
std::optional<StandIns> in_names_of_coordinates(const Dataset& dataset,
                                                const DiagnoseOptions& options);

// Sentences: lengths and angles under a name of their own that the baseline does not read, so that
// no cause does.
std::vector<std::string> unread_coordinates(const Dataset& dataset, const DiagnoseOptions& options);

// Nothing where the file has both, or neither: pose coordinates that are outputs or do not repeat
// are measured, more than three lengths or one angle are no axes of a machine. Where a motor's
// place is the output its pose is missing, not named otherwise.
std::optional<StandIns> stand_ins(const Dataset& dataset, const DiagnoseOptions& options);

// The findings, sentences and formulas with the file's own names.
void name_as_in_file(const StandIns& stand_ins, Diagnosis& diagnosis);

}  // namespace driftwise::diagnosis
