#include "server/rpc/watch/watch_cursor.h"

#include <array>
#include <charconv>

namespace driftwise::rpc {
namespace {

constexpr std::array kFields = {
    &RecordCursor::event, &RecordCursor::attempt,   &RecordCursor::point, &RecordCursor::alarm,
    &RecordCursor::model, &RecordCursor::promotion, &RecordCursor::job};

}  // namespace

std::string cursor_text(const WatchCursor& cursor) {
  std::string out = cursor.database;
  for (const auto field : kFields) out += "." + std::to_string(cursor.records.*field);
  return out;
}

std::optional<WatchCursor> cursor_from(std::string_view text) {
  WatchCursor out;
  const std::size_t first = text.find('.');
  if (first == std::string_view::npos || first == 0 || text.size() > 200) return std::nullopt;
  out.database = std::string(text.substr(0, first));
  const char* at = text.data() + first;
  const char* end = text.data() + text.size();
  for (const auto field : kFields) {
    if (at == end || *at != '.') return std::nullopt;
    const auto [stop, bad] = std::from_chars(at + 1, end, out.records.*field);
    if (bad != std::errc{} || out.records.*field < 0) return std::nullopt;
    at = stop;
  }
  return at == end ? std::optional(out) : std::nullopt;
}

bool is_known_cursor(const WatchCursor& cursor, const WatchCursor& newest) {
  if (cursor.database != newest.database) return false;
  for (const auto field : kFields)
    if (cursor.records.*field > newest.records.*field) return false;
  return true;
}

}  // namespace driftwise::rpc
