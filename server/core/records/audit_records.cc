#include "server/core/records/audit_records.h"

#include <algorithm>
#include <charconv>

namespace driftwise {

std::string to_string(const ChainHead& head) {
  return head.hash + "@" + std::to_string(head.entry);
}

std::optional<ChainHead> chain_head_from(const std::string& text) {
  constexpr std::size_t kDigits = 64;
  const auto is_digit = [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); };
  if (text.size() < kDigits + 2 || text[kDigits] != '@') return std::nullopt;
  ChainHead head{0, text.substr(0, kDigits)};
  if (!std::ranges::all_of(head.hash, is_digit)) return std::nullopt;
  const char* const end = text.data() + text.size();
  const auto [stop, code] = std::from_chars(text.data() + kDigits + 1, end, head.entry);
  if (code != std::errc{} || stop != end || head.entry < 1) return std::nullopt;
  return head;
}

}  // namespace driftwise
