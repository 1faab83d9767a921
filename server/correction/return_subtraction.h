#pragma once
// Zeros of a run: alignment at pose zero, and the subtraction of neighbouring returns to zero
// (Lubrano 2011, footnote 13: x_k - [Z_j + (Z_j+1 - Z_j)(t_k - t_j)/(t_j+1 - t_j)]).

#include <map>
#include <string>
#include <vector>

#include "server/core/result.h"
#include "server/correction/join_part.h"

namespace driftwise::correction {

// A pose coordinate, or the path of an interferometer: what counts from a zero.
bool counts_from_zero(const Channel& channel);

// What the returns to zero of a run scatter by when the line between their neighbours is taken off
// (sigma of one return), per channel that counts from zero; in the channel's unit. With less than
// three returns in a datum: nothing of that datum. Asked before one of the functions below.
std::map<std::string, double> scatter_of_returns(const JoinPart& part,
                                                 const std::vector<std::size_t>& zeros);
// Root mean square of the returns about their centre: with the drift of the run, which is smooth,
// goes one way for most of a session or waits in one place and then leaves it, so that a robust
// sigma of its values states too little. Of a length less the motors' own deviations there, the
// holding error, which a join counts row by row. Returns that jump are left out (without_jumps).
// Nothing of a channel with less than two returns in every datum.
std::map<std::string, double> spread_of_returns(const JoinPart& part,
                                                const std::vector<std::size_t>& zeros);

// Values in time order without those that are off the line between their two neighbours by more
// than five robust standard deviations of such distances: a wrong return jumps, a drift does not.
std::vector<double> without_jumps(const std::vector<double>& values);

// Subtracts the centre of the returns (median of the means of all pairs), datum by datum; a datum
// without a return takes that of all. The holding error puts each return at one of two places, and
// a median would be at one of them, another one in each run.
void align_zeros(const std::vector<std::size_t>& zeros, JoinPart& part);

// Subtracts the line between the returns before and after each row, within one datum; before the
// first and after the last one the nearest return. Errors: invalid_argument NO_POSE_ZERO (no
// time_s, or less than two returns).
Result<void> subtract_returns(const std::vector<std::size_t>& zeros, JoinPart& part);

}  // namespace driftwise::correction
