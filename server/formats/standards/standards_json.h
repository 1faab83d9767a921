#pragma once
// The standards' figures as JSON: driftwise.iso230-2.v1, driftwise.iso230-3.v1,
// driftwise.iso9283.v1 (docs/standards.md).

#include <nlohmann/json.hpp>

#include "server/standards/iso230_2.h"
#include "server/standards/iso230_3.h"
#include "server/standards/iso9283.h"

namespace driftwise::formats {

nlohmann::ordered_json standards_json(const standards::Iso2302& figures);
nlohmann::ordered_json standards_json(const standards::Iso2303& figures);
nlohmann::ordered_json standards_json(const standards::Iso9283& figures);

}  // namespace driftwise::formats
