#pragma once

#include <optional>
#include <string>

#include "server/core/description/cell_description.h"
#include "server/core/ports/store.h"

namespace driftwise::application {

// The description of a configuration in the record: the present one, or its text read again; none:
// this program cannot read it.
std::optional<CellDescription> stored_description(Store& store, const std::string& hash,
                                                  const CellDescription& present);

}  // namespace driftwise::application
