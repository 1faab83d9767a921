#pragma once
// The [[pose]] tables of a mapping file: which channels are a measured pose, and the rigid
// transformations to the wanted one.

#include "server/formats/import/import_mapping.h"
#include "server/formats/text/toml_reader.h"

namespace driftwise::formats {

// place: "pose 1". Keys: position, rotation, convention, into_position, into_rotation,
// into_convention, and the tables frame and tool, each of
//   matrix = 4 rows of 4 numbers, lengths in mm, or
//   translation_mm = [x, y, z] and rotation_deg = [a, b, c] with its convention;
//   inverse = true when it is given the other way round.
// Problems: those of read_import_mapping.
void read_pose(const toml::table& table, const std::string& place, TomlProblem& problem,
               PoseRule& out);

}  // namespace driftwise::formats
