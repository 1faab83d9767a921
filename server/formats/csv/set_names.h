#pragma once
// Names of validation sets. In the column `set` of a dataset or a trajectory every word but
// "calibration" marks a validation row; a word other than "validation" names its set, so that
// tables can be made by name. A Dataset keeps which rows validate; the names stay with the text.

#include <string>
#include <string_view>
#include <vector>

#include "server/core/result.h"

namespace driftwise::formats {

// Whether a word may stand in the column: calibration, or a name of a validation set. What could be
// meant as "calibration" and is written otherwise is no name: its rows would leave the fit.
bool is_set_name(std::string_view word);
constexpr const char* kSetNameExpected =
    "calibration, validation, or the name of a validation set: a letter, then up to 31 letters, "
    "digits, '-' or '_', not beginning with cal or kal";

// Per row of the text, in its order: "calibration", "validation", "inside". Empty: the text has no
// column `set`. Errors: those of read_csv_header; BAD_SET.
Result<std::vector<std::string>> read_set_names(std::string_view text,
                                                const std::string& file_name);

// The same text with other words in its column `set`, one per row; without that column, or where
// the number of rows is another, as it was.
std::string with_set_names(std::string_view text, const std::vector<std::string>& names);

// The names as one line of metadata, and back: "calibration*600 inside*150". Empty: there are none,
// or the line is not such a line, or it does not name exactly `rows` rows.
std::string packed_set_names(const std::vector<std::string>& names);
std::vector<std::string> unpacked_set_names(std::string_view line, std::size_t rows);
constexpr std::string_view kSetNamesKey = "set_names";

// Names beyond calibration and validation, in the order of their first row.
std::vector<std::string> named_sets(const std::vector<std::string>& names);

}  // namespace driftwise::formats
