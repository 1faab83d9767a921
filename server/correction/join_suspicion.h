#pragma once
// Joins that look right and are not: rows shifted against one another, coordinates of another
// set-up under the name of this one.

#include "server/core/result.h"
#include "server/correction/join_part.h"

namespace driftwise::correction {

// The parts row by row: index[p][k] is the row of part p's data that is row k of the join.
struct MatchedRows {
  std::vector<std::vector<std::size_t>> index;
  std::vector<std::int64_t> row;  // of the trajectory, from 0, ascending
};

// Difference of one channel between two parts over the matched rows; sources named.
JoinCheck difference_of(const JoinParts& parts, const MatchedRows& rows, std::size_t a,
                        std::size_t b, const Channel& of_a, const Channel& of_b);

// Two parts whose values are the same to the last bit in every channel that both have, at least one
// of them a pose coordinate: one measurement given twice, which would be joined with an uncertainty
// of 0. Errors: invalid_argument NOTHING_TO_JOIN.
Result<void> check_measured_once(const JoinParts& parts, const MatchedRows& rows);

// Rows of a part whose pose belongs to the motor coordinates of a neighbouring row; rows of two
// parts that agree only when one is moved by some rows. Errors: failed_precondition ROWS_SHIFTED.
Result<void> check_rows_shifted(const JoinParts& parts, const MatchedRows& rows);

// A coordinate of one part that agrees with another coordinate of the other part and not with its
// own name; a length that follows another coordinate of a trajectory of poses. Errors:
// failed_precondition SETUPS_SWAPPED.
Result<void> check_setups_swapped(const JoinParts& parts, const MatchedRows& rows);

}  // namespace driftwise::correction
