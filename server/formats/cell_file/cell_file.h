#pragma once
// cell.toml -> CellDescription. The manual with every key, unit and default: docs/cell-file.md.
// Nothing is half-read: the first problem ends it, with file:line, the key, what was found and what
// was expected.

#include <string>
#include <string_view>

#include "server/core/description/cell_description.h"

namespace driftwise::formats {

// kinds: those that [[device]] kind may name; each reads its own settings. They outlive the result.
// path: the file's name, for messages, and the folder that relative paths inside ([cell] database,
// [clock] file) start from. The file itself is not opened. Errors, invalid_argument: TOML_SYNTAX,
// UNKNOWN_KEY (with the nearest known one), MISSING_KEY, WRONG_TYPE,
//   OUT_OF_RANGE, BAD_ADDRESS, BAD_CHANNEL, BAD_TIME, UNKNOWN_KIND, DUPLICATE_ID,
//   DUPLICATE_CHANNEL, BAD_LIMITS, LISTEN_NOT_LOOPBACK, NEEDS_TLS, and those of cell_file_robots.h;
//   failed_precondition: SPEED_NEEDS_LOOPBACK.
Result<CellDescription> parse_cell_file(std::string_view text, const std::string& path,
                                        DeviceKinds kinds);

// Reads the file, then parses it. Errors: those above; not_found, NO_FILE; invalid_argument,
// NOT_A_FILE (a folder).
Result<CellDescription> read_cell_file(const std::string& path, DeviceKinds kinds);

// [web] root of the cell file at this path, absolute; empty: none is named.
std::string web_root_of(const CellDescription& cell, const std::string& path);

// Place of the device in the cell file, in front of a driver's complaint: "cell.toml:12: ". The
// line is that of the option that the complaint names, else of the device. Empty: the description
// was not made from a file.
std::string device_place(const CellDescription& cell, const std::string& path, std::size_t device,
                         std::string_view complaint);

}  // namespace driftwise::formats
