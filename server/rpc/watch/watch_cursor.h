#pragma once
// The cursor of a watch as text: whose database, and the last record of each kind. Opaque to
// clients. Pure.

#include <optional>
#include <string>
#include <string_view>

#include "server/core/records/watch_records.h"

namespace driftwise::rpc {

struct WatchCursor {
  std::string database;
  RecordCursor records;
};

std::string cursor_text(const WatchCursor& cursor);
std::optional<WatchCursor> cursor_from(std::string_view text);  // nothing: not one of ours

// Whether the cursor means something to a database whose newest records these are: its own, and not
// ahead of it (a backup was put back).
bool is_known_cursor(const WatchCursor& cursor, const WatchCursor& newest);

}  // namespace driftwise::rpc
