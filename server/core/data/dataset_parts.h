#pragma once
// The line "# parts: t05=robot t01=instrument" in the metadata of a dataset: on which part each
// thermometer is, as the cell file declares it. What R stands for in a formula.

#include <string>
#include <utility>
#include <vector>

namespace driftwise {

inline constexpr const char* kPartsKey = "parts";
using Parts = std::vector<std::pair<std::string, std::string>>;  // symbol, part

// Words without "=" are passed over; the last one that names a symbol counts. Empty: no such line.
Parts parts_from(const std::vector<std::pair<std::string, std::string>>& metadata);
std::string parts_text(const Parts& parts);

}  // namespace driftwise
