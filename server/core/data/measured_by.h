#pragma once
// The line "# measured_by: ma.z=probe ma.rx=collimator x=laser-1*120,laser-2*80" in the metadata of
// a dataset: which instrument of the cell gave each coordinate of the pose, where set-ups choose
// among several. "a+b": every value is the mean of the readings of both; "a*120,b*80": of 120 rows
// and of 80 others.

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace driftwise {

inline constexpr const char* kMeasuredByKey = "measured_by";

struct MeasuredRows {
  std::vector<std::string> devices;  // at least one; of several, the value is their mean
  double rows = 1;                   // above 0
  bool operator==(const MeasuredRows&) const = default;
};

struct MeasuredBy {
  std::string symbol;               // "ma.z"
  std::vector<MeasuredRows> parts;  // at least one
  bool operator==(const MeasuredBy&) const = default;

  // Mean over the rows of what the device's reading counts for in a value: 1 where it gave all of
  // them, 0 where none.
  double weight(std::string_view device) const;
};

// Words that are not as above are passed over; the last one that names a symbol counts. Empty: no
// such line.
std::vector<MeasuredBy> measured_by_from(
    const std::vector<std::pair<std::string, std::string>>& metadata);
// Without the coordinates of devices whose id the notation cannot hold (a blank, '=', ',', '+' or
// '*' in it).
std::string measured_by_text(const std::vector<MeasuredBy>& coordinates);

// Null: not stated.
const MeasuredBy* find_measured_by(const std::vector<MeasuredBy>& coordinates,
                                   std::string_view symbol);

}  // namespace driftwise
