#pragma once
// The dataset CSV of docs/formats.md: leading "# key: value" lines, one header row of
// <channel>_<unit> names, one row per accepted point in time order. Text <-> values, exact both
// ways: a number is written with the fewest digits that read back as the same double, and read by
// correct rounding.
//
// Accepted on reading: LF or CRLF ends, a UTF-8 byte order mark, spaces and tabs around a field, a
// last line without its end, empty lines. An empty field is kMissing; an empty field of set, line,
// zero, run, datum, excluded or time_s is an error. Not accepted: quotes, "nan" and "inf" as text,
// ragged rows, two columns of one name.

#include <string>
#include <string_view>

#include "server/calibration/model/executor.h"
#include "server/core/data/dataset.h"
#include "server/formats/csv/csv_text.h"

namespace driftwise::formats {

constexpr std::string_view kDatasetVersionKey = "driftwise-dataset";

// file_name: stands in front of every message ("drift.csv:7: ..."); the file itself is not opened.
// Errors, all invalid_argument, each naming file:line, the column, what was found and what was
// expected:
//   EMPTY_FILE, NO_HEADER, NO_ROWS, BAD_CHANNEL (no unit), DUPLICATE_COLUMN, RAGGED_ROW,
//   BAD_NUMBER, BAD_SET, BAD_FLAG, BAD_INTEGER, TIME_NOT_INCREASING, QUOTED_FIELD, BAD_METADATA,
//   UNSUPPORTED_VERSION, NOT_TEXT; TOO_MANY_VALUES and the other limits (csv_text.h).
// Time and memory are proportional to the text.
// executor: large files are read on its threads; the dataset and the errors are the same on any.
Result<Dataset> read_dataset_csv(std::string_view text, const std::string& file_name,
                                 const calibration::Executor& executor = {},
                                 const CsvLimits& limits = {});

// The metadata lines as they stand (driftwise-dataset: 1 is put first when it is missing), then the
// rows. Columns in this order: time_s, run, datum, set, line, zero, dwell_s,
// excluded where present, then the channels in theirs.
std::string write_dataset_csv(const Dataset& dataset);

}  // namespace driftwise::formats
