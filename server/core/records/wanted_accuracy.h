#pragma once
// The accuracy that a campaign wants, as metadata of its runs: "wanted_a90.x_nm=100" for one
// coordinate, "wanted_a90_nm=100" for every coordinate of that unit without a figure of its own.

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/core/records/run_metadata.h"
#include "server/core/result.h"

namespace driftwise {

struct WantedAccuracy {
  std::string coordinate;  // "x", "ma.rx"; empty: every coordinate of the unit
  std::string unit;        // summary unit: "nm", "arcsec"
  double a90 = 0;          // in it
  bool operator==(const WantedAccuracy&) const = default;
};

// Whether a key of metadata states a wanted accuracy, well or badly.
bool states_wanted_accuracy(std::string_view key);

// Lengths and angles in any known unit of theirs. Errors: invalid_argument BAD_METADATA: a key
// without a length or an angle, a value that is no number above 0.
Result<WantedAccuracy> wanted_accuracy_from(const MetadataItem& item);

// Of several figures for one coordinate (two runs of a campaign) the smallest.
void add_wanted(std::vector<WantedAccuracy>& wanted, WantedAccuracy one);

// For a pose coordinate its own figure, else that of its unit. For a motor coordinate that of its
// unit, else the smallest of any coordinate of its robot in it: which one it carries is not asked.
// nullptr: none.
const WantedAccuracy* wanted_of(std::span<const WantedAccuracy> wanted, std::string_view symbol,
                                std::string_view unit);

// "x 100 nm, every rotation 2 arcsec".
std::string wanted_text(std::span<const WantedAccuracy> wanted);

}  // namespace driftwise
