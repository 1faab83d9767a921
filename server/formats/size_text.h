#pragma once
// A figure at the size people say it in.

#include <string>

namespace driftwise::formats {

// 41.3 nm, 432 um, 3.01 mm for a size in nm, four digits, "nm" up to 10 000 of them; another unit
// (arcsec) stays, with three digits. Any thread.
std::string size_text(double size, const std::string& unit);

}  // namespace driftwise::formats
