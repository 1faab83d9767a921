#pragma once
// The comma-separated text that datasets and trajectories share: a header, then rows that are read
// field by field in one pass straight from the text, without copies. What is a column's meaning is
// the caller's business.

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/calibration/model/executor.h"
#include "server/core/reasons.h"
#include "server/core/result.h"

namespace driftwise::formats {

// Bounds on a table, whoever sent it: what is beyond them is refused before memory is taken for it.
struct CsvLimits {
  std::size_t columns = 4096;           // a cell has tens of channels
  std::size_t name_bytes = 128;         // of a column's name
  std::size_t header_bytes = 1u << 20;  // of the header row
  std::size_t metadata_lines = 10'000;
  // Rows x columns; the time and memory of what follows are proportional to it.
  std::size_t values = std::numeric_limits<std::size_t>::max();
};

// Of a table that a client hands to the daemon: 32 MB of doubles.
constexpr CsvLimits kRequestLimits{.values = 4'000'000};

struct CsvHeader {
  // Leading '#' lines: "# key: value"; a line without a colon has an empty key and is its value.
  std::vector<std::pair<std::string, std::string>> metadata;
  std::vector<std::string> names;
  std::size_t line = 0;   // of the header row, from 1
  std::string_view rows;  // the text after the header row
};

// Whole lines of the text after the header row, that one thread reads.
struct CsvChunk {
  std::string_view rows;
  std::size_t line = 0;       // before its first
  std::size_t most_rows = 0;  // no more than this
  std::size_t first_row = 0;  // no more rows than this in all chunks before it
};

// About a megabyte each: the cuts depend on the text alone, not on who reads it.
std::vector<CsvChunk> chunks_of(const CsvHeader& header,
                                const calibration::Executor& executor = {});

// Linear in the size of the header. Errors: EMPTY_FILE, NO_HEADER, NOT_TEXT, QUOTED_FIELD,
// DUPLICATE_COLUMN; an empty name is NO_HEADER's too; TOO_MANY_COLUMNS, NAME_TOO_LONG,
// HEADER_TOO_LONG, TOO_MUCH_METADATA (the limits). Control characters in metadata are replaced
// (core/clean_text.h).
Result<CsvHeader> read_csv_header(std::string_view text, const std::string& file_name,
                                  const CsvLimits& limits = {});

// Walks over the rows. Each field is asked for once, in order, by the function of its kind; false
// means that error() says what is wrong, with file:line and the column's name, and the walk is
// over.
class CsvRows {
 public:
  CsvRows(const CsvHeader& header, const std::string& file_name, const CsvChunk& chunk);

  bool next_row();             // false at the end of the text, or after an error; skips empty lines
  bool number(double& value);  // an empty field is kMissing
  bool integer(std::int64_t& value);
  bool flag(bool& value);               // 0 or 1
  bool text(std::string& value);        // as it stands, without the blanks around it
  bool set_is_validation(bool& value);  // calibration or validation
  bool failed() const { return failed_; }
  Error error() const { return error_; }
  std::size_t line() const { return line_; }
  // A problem that the caller found in the field just read, or in the row.
  Error problem(std::string reason, std::size_t column, const std::string& sentence) const;

 private:
  bool finish_field(const char* after, const char* expected, Reason reason);
  bool refuse(Reason reason, const char* expected);
  std::string surplus(std::size_t fields) const;
  std::string_view field() const;
  std::string_view row() const;

  const char* at_;
  const char* end_;
  const char* field_ = nullptr;  // where the present field starts
  const char* row_ = nullptr;
  std::size_t line_;
  std::size_t column_ = 0;
  const std::vector<std::string>& names_;
  const std::string& file_name_;
  bool in_row_ = false, failed_ = false;
  Error error_{};
};

}  // namespace driftwise::formats
