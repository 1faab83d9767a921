#pragma once
// Place::requeued as it stands in run_progress.requeued: "row:count row:count", empty for none.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/core/records/records.h"

namespace driftwise::storage {

std::string requeued_text(const std::vector<Requeued>& requeued);
std::optional<std::vector<Requeued>> requeued_from(
    std::string_view text);  // none: not of this form

}  // namespace driftwise::storage
