#pragma once
// The standards' figures as a page for people: plain text, nm and arcsec.

#include <string>

#include "server/standards/iso230_2.h"
#include "server/standards/iso230_3.h"
#include "server/standards/iso9283.h"

namespace driftwise::formats {

std::string standards_page(const standards::Iso2302& figures);
std::string standards_page(const standards::Iso2303& figures);
std::string standards_page(const standards::Iso9283& figures);

}  // namespace driftwise::formats
