#pragma once
// Metadata of a run: keys with values, for people and for searches ("sample" = "A12").
//
// A key: 1 to 64 letters, digits, '.', '_' or '-'. A value: 1 to 256 bytes of one line. Each key
// once, in ascending order.

#include <string>
#include <string_view>
#include <vector>

#include "server/core/result.h"

namespace driftwise {

struct MetadataItem {
  std::string key, value;
  bool operator==(const MetadataItem&) const = default;
};
using RunMetadata = std::vector<MetadataItem>;

// Checked and put in order. Errors: invalid_argument BAD_METADATA (a key, a value, the same key
// twice, more than 50 of them).
Result<RunMetadata> checked_metadata(RunMetadata items);

// "sample=A12", as a person writes it. Errors: invalid_argument BAD_METADATA.
Result<MetadataItem> metadata_item_from(std::string_view text);

// A line per item: what the database keeps of a queue entry. Reading takes what writing gave.
std::string metadata_lines(const RunMetadata& metadata);
RunMetadata metadata_from_lines(std::string_view lines);

// "purpose=drift, sample=A12"; empty: none.
std::string metadata_text(const RunMetadata& metadata);

// What `set` says replaces what is there; keys of `removed` go.
RunMetadata changed_metadata(RunMetadata metadata, const RunMetadata& set,
                             const std::vector<std::string>& removed);

}  // namespace driftwise
