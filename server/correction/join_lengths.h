#pragma once
// Lengths of joined runs, corrected by the rotations of all of them: each part keeps its own paths,
// so that a length which two parts measured stays two measurements.
//
// Lengths in mm, rotations in arcsec, whatever the columns' units. Pure; one thread.

#include <array>
#include <cstddef>

#include "server/core/units.h"
#include "server/correction/join_part.h"
#include "server/correction/join_suspicion.h"

namespace driftwise::correction {

inline constexpr std::array<const char*, 3> kLengths = {"x", "y", "z"};
inline constexpr std::array<const char*, 3> kAngles = {"rx", "ry", "rz"};

inline double arcsec_per_unit(const Channel& channel) { return summary_unit(channel.unit).factor; }
inline double mm_per_unit_of(const Channel& channel) {
  return mm_from_nm(summary_unit(channel.unit).factor);
}
bool has_values(const DatasetColumn& column);

// Standard uncertainty of each joined angle, arcsec; for what it does to a length.
using AngleU = std::array<double, 3>;

struct CorrectedLengths {
  // Share of the angles' own uncertainty in each length, root mean square over the rows.
  std::array<double, 3> u_mm{};
  std::size_t rows_without_angle = 0;  // a length of theirs is missing now
};

// A length is made missing in a row without an angle that it depends on and that the runs measured
// in other rows: uncorrected it would be off by what the tilt does, and look like its neighbours.
CorrectedLengths correct_lengths(const MatchedRows& rows, const AngleU& u_arcsec, JoinParts& parts);

}  // namespace driftwise::correction
