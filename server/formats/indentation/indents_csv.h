#pragma once
// Tables of indents as text: the table by itself, and what a microscope gives. docs/indentation.md
// has the columns.

#include <string>
#include <string_view>
#include <vector>

#include "server/core/result.h"
#include "server/indentation/indent_table.h"
#include "server/indentation/microscope_rows.h"

namespace driftwise::formats {

using indentation::MicroscopeIndent;

// Columns in any order: id, line (x or y), wanted_um, rx_arcsec, ry_arcsec, measured_um, pixel_nm,
// marking_px, pictures_joined; diagonal_um may be missing. Errors: those of read_csv_header;
// UNKNOWN_COLUMN, NO_COLUMN, BAD_NUMBER, BAD_VALUE (line), NO_ROWS, each with file:line.
Result<std::vector<indentation::Indent>> read_indents_csv(std::string_view text,
                                                          const std::string& file_name);
std::string write_indents_csv(const std::vector<indentation::Indent>& indents);

// Columns in any order: id, x_um, y_um, pixel_nm, marking_px, pictures_joined; diagonal_um may be
// missing. Errors as above.
Result<std::vector<MicroscopeIndent>> read_microscope_csv(std::string_view text,
                                                          const std::string& file_name);

}  // namespace driftwise::formats
