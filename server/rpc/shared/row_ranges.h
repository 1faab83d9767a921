#pragma once
// Rows as ranges without gaps, as messages hold them.

#include <cstdint>
#include <vector>

#include "server/core/records/diagnosis_records.h"
#include "server/rpc/shared/convert_values.h"

namespace driftwise::rpc {

// rows: stored ones, ascending. add_range(): a new message with first_row and last_row.
template <class AddRange>
void add_ranges(const std::vector<std::int64_t>& rows, const AddRange& add_range) {
  for (std::size_t i = 0; i < rows.size();) {
    std::size_t end = i + 1;
    while (end < rows.size() && rows[end] == rows[end - 1] + 1) ++end;
    auto* range = add_range();
    range->set_first_row(shown_row(rows[i]));
    range->set_last_row(shown_row(rows[end - 1]));
    i = end;
  }
}

// The same for a message that has each range with its run.
template <class Message>
void add_excluded_ranges(const RowsOfRun& rows, Message& out) {
  add_ranges(rows.rows, [&] {
    auto* range = out.add_excluded();
    range->set_run_id(rows.run.value);
    return range;
  });
}

}  // namespace driftwise::rpc
