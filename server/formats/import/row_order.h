#pragma once
// The instants of a file's rows -> time_s, increasing over the whole dataset.

#include <cstdint>
#include <string>
#include <vector>

#include "server/core/cell_time.h"
#include "server/formats/import/import_mapping.h"

namespace driftwise::formats {

class RowTimes {
 public:
  // local: the stamp says no zone.
  void add(CellTime time, std::size_t line, bool local = false) {
    rows_.push_back({time, line, local});
  }

  struct Ordered {
    std::vector<std::size_t> rows;  // the row that comes first, second, ...
    std::vector<double> time_s;     // from zero
    CellTime zero;  // the first one's instant; 0 with a format that counts from a start of its own
    std::size_t late = 0;    // rows that stood after a later one
    std::size_t spread = 0;  // rows that share the stamp of the one before
  };
  // By the mapping's rules: rows stay where they are, or are put in order of time (equal times as
  // they stood); n rows of one stamp share the resolution evenly, when that is allowed.
  // Errors: TIME_NOT_INCREASING naming both lines and the key that would allow it; so does a clock
  // that was set back at the end of summer time, in any order: sorting would mix two hours.
  Result<Ordered> put_in_order(const TimeRules& rules, const std::string& file_name) const;

 private:
  struct Row {
    CellTime time;
    std::size_t line;
    bool local;
  };
  std::vector<std::int64_t> forward_steps_ns() const;
  std::vector<std::size_t> rows_of_clock_set_back() const;  // ascending
  std::vector<Row> rows_;
};

template <class T>
std::vector<T> in_order(const std::vector<T>& values, const std::vector<std::size_t>& rows) {
  std::vector<T> out;
  out.reserve(rows.size());
  for (const std::size_t row : rows) out.push_back(values[row]);
  return out;
}

}  // namespace driftwise::formats
