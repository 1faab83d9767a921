#pragma once
// Lines of a dataset's metadata that a computation reads: a slip in one of them would change a
// result without a word.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "server/core/data/dataset.h"
#include "server/core/result.h"

namespace driftwise::formats {

struct MetadataSlip {
  std::size_t entry = 0;  // of data.metadata
  std::string sentence;   // "found 'tO5=robot', but the data have no channel ..."
};

// The first in "# parts:", "# measured_by:" and "# overruns:" (docs/formats.md). A part of a
// channel that the data do not have is a slip only where one of their thermometers has no part.
std::optional<MetadataSlip> metadata_slip(const Dataset& data);

// data: as read from text. Errors: BAD_METADATA, with line, word and what was expected.
Result<void> check_metadata(std::string_view text, const Dataset& data,
                            const std::string& file_name);

}  // namespace driftwise::formats
