#pragma once
// A table as other programs write it: any separator, quotes, comment lines, lines before the
// header, decimal commas. Row by row, fields as text; what they mean is the mapping's business.
//
// Quotes: a field that begins with " ends at the next single "; "" inside is one ". A line break
// inside quotes is refused. Blanks around a field are taken off, a quoted one's outside only. Empty
// lines and comment lines are passed over, also before the header.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/core/reasons.h"
#include "server/core/result.h"

namespace driftwise::formats {

struct TableLayout {
  char separator = ',';
  bool blanks_separate = false;  // any number of spaces and tabs instead of one separator
  bool quotes = true;
  std::string comment = "#";  // lines that begin so are passed over; empty: there are none
  int skip_lines = 0;         // before anything else, whatever they hold
};

class ForeignRows {
 public:
  // text and file_name outlive the walk.
  ForeignRows(std::string_view text, const TableLayout& layout, const std::string& file_name);

  // Goes to the next row; false at the end of the text or after an error.
  // Errors: BAD_QUOTE, LONG_LINE (over 1 MiB: no table).
  bool next();
  const std::vector<std::string>& fields() const { return fields_; }
  std::size_t line() const { return line_; }  // of the present row, from 1
  const std::optional<Error>& error() const { return error_; }

 private:
  bool split(std::string_view row);
  bool refuse(Reason reason, const std::string& sentence);
  std::string& fresh_field();

  std::string_view rest_;
  const TableLayout& layout_;
  const std::string& file_name_;
  std::size_t line_ = 0, used_ = 0;
  std::vector<std::string> fields_;  // kept between rows, so that their memory is
  std::optional<Error> error_;
};

}  // namespace driftwise::formats
