#include "storage/rows/place_text.h"

#include <charconv>

namespace driftwise::storage {

std::string requeued_text(const std::vector<Requeued>& requeued) {
  std::string text;
  for (const auto& entry : requeued)
    text +=
        (text.empty() ? "" : " ") + std::to_string(entry.row) + ":" + std::to_string(entry.count);
  return text;
}

std::optional<std::vector<Requeued>> requeued_from(std::string_view text) {
  std::vector<Requeued> requeued;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (at != end) {
    Requeued entry;
    const auto row = std::from_chars(at, end, entry.row);
    if (row.ec != std::errc{} || row.ptr == end || *row.ptr != ':') return std::nullopt;
    const auto count = std::from_chars(row.ptr + 1, end, entry.count);
    if (count.ec != std::errc{}) return std::nullopt;
    requeued.push_back(entry);
    at = count.ptr;
    if (at == end) break;
    if (*at != ' ' || at + 1 == end) return std::nullopt;
    ++at;
  }
  return requeued;
}

}  // namespace driftwise::storage
