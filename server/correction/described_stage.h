#pragma once

#include <string_view>

#include "server/core/description/cell_description.h"
#include "server/correction/correction.h"

namespace driftwise::correction {

// The stage that a cell file describes for one robot; empty: of a cell whose channels carry no id.
Stage stage_from(const CorrectionDescription& description, std::string_view robot = "");

}  // namespace driftwise::correction
