#pragma once
// The [kinematics] section: of cell.toml, or alone in a robot file for offline work. The manual
// with every key: docs/kinematics.md.

#include <string>
#include <string_view>

#include "server/core/description/kinematics_description.h"
#include "server/formats/text/toml_reader.h"

namespace driftwise::formats {

// Problems go to the reader's: MISSING_KEY, UNKNOWN_KEY, WRONG_TYPE, OUT_OF_RANGE, UNKNOWN_KIND,
// BAD_CHANNEL, and what kinematics::make_mechanism says of the whole (BAD_KINEMATICS,
// UNKNOWN_PARAMETER).
void read_kinematics(const toml::table& table, KinematicsDescription& out, TomlProblem& problem);

// A text with a [kinematics] section: a robot file, or a whole cell.toml whose other sections are
// passed over. Errors, invalid_argument: TOML_SYNTAX, NO_KINEMATICS, those above; each with
// file_name:line.
Result<KinematicsDescription> parse_robot_file(std::string_view text, const std::string& file_name);

// The robot file that reads back as this description.
std::string write_robot_file(const KinematicsDescription& description);

}  // namespace driftwise::formats
