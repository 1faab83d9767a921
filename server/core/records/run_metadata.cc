#include "server/core/records/run_metadata.h"

#include <algorithm>

#include "server/core/reasons.h"
#include "server/core/records/wanted_accuracy.h"
#include "server/core/text/clean_text.h"
#include "server/core/text/shown_text.h"
#include "server/core/try.h"

namespace driftwise {
namespace {

constexpr std::size_t kMostItems = 50, kMostKeyBytes = 64, kMostValueBytes = 256;

bool is_of_key(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
         c == '_' || c == '-';
}

Result<void> check_item(const MetadataItem& item) {
  if (item.key.empty() || item.key.size() > kMostKeyBytes ||
      !std::ranges::all_of(item.key, is_of_key))
    return fail(ErrorCode::invalid_argument, reasons::kBadMetadata,
                "metadata: found key " + shown(item.key) +
                    ", expected 1 to 64 letters, digits, '.', '_' or '-'");
  if (item.value.empty() || item.value.size() > kMostValueBytes ||
      clean_line(item.value) != item.value)
    return fail(ErrorCode::invalid_argument, reasons::kBadMetadata,
                "metadata: found value " + shown(item.value) + " of key " + shown(item.key) +
                    ", expected 1 to 256 bytes of one line");
  return {};
}

}  // namespace

Result<RunMetadata> checked_metadata(RunMetadata items) {
  if (items.size() > kMostItems)
    return fail(ErrorCode::invalid_argument, reasons::kBadMetadata,
                "metadata: found " + std::to_string(items.size()) + " keys, expected at most 50");
  for (const auto& item : items) {
    DRIFTWISE_RETURN_IF_ERROR(check_item(item));
    if (!states_wanted_accuracy(item.key)) continue;
    DRIFTWISE_RETURN_IF_ERROR(wanted_accuracy_from(item));
  }
  std::ranges::sort(items, {}, &MetadataItem::key);
  const auto twice = std::ranges::adjacent_find(items, {}, &MetadataItem::key);
  if (twice != items.end())
    return fail(ErrorCode::invalid_argument, reasons::kBadMetadata,
                "metadata: found key " + shown(twice->key) + " twice, expected each key once");
  return items;
}

Result<MetadataItem> metadata_item_from(std::string_view text) {
  const auto equals = text.find('=');
  if (equals == std::string_view::npos)
    return fail(ErrorCode::invalid_argument, reasons::kBadMetadata,
                "metadata: found " + shown(text) + ", expected key=value: sample=A12");
  MetadataItem item{std::string(text.substr(0, equals)), std::string(text.substr(equals + 1))};
  DRIFTWISE_RETURN_IF_ERROR(check_item(item));
  return item;
}

std::string metadata_lines(const RunMetadata& metadata) {
  std::string lines;
  for (const auto& item : metadata) lines += item.key + "=" + item.value + "\n";
  return lines;
}

RunMetadata metadata_from_lines(std::string_view lines) {
  RunMetadata metadata;
  while (!lines.empty()) {
    const auto end = std::min(lines.find('\n'), lines.size());
    if (auto item = metadata_item_from(lines.substr(0, end))) metadata.push_back(std::move(*item));
    lines.remove_prefix(std::min(end + 1, lines.size()));
  }
  return metadata;
}

std::string metadata_text(const RunMetadata& metadata) {
  std::string text;
  for (const auto& item : metadata)
    text += (text.empty() ? "" : ", ") + item.key + "=" + item.value;
  return text;
}

RunMetadata changed_metadata(RunMetadata metadata, const RunMetadata& set,
                             const std::vector<std::string>& removed) {
  std::erase_if(metadata, [&](const MetadataItem& item) {
    return std::ranges::find(removed, item.key) != removed.end() ||
           std::ranges::find(set, item.key, &MetadataItem::key) != set.end();
  });
  metadata.insert(metadata.end(), set.begin(), set.end());
  std::ranges::sort(metadata, {}, &MetadataItem::key);
  return metadata;
}

}  // namespace driftwise
