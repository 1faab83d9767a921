#pragma once
// The last word belongs to rows that took no part: a cause with which any output's rows held out
// are described worse than without it (root mean square, mean included, by more than 2 % and beyond
// its 90 % interval) does not stand, and all findings together are held to the same.

#include <optional>
#include <string>
#include <vector>

#include "server/diagnosis/growth/extension.h"
#include "server/diagnosis/search/coordinate_frame.h"

namespace driftwise::diagnosis {

struct Harmful {
  std::size_t cause = 0;
  std::string sentence;
};

// Takes back what harms, the worst first, until nothing does. What harms one output and helps
// another, beyond the interval, is left out of the one only where the others still show it, and
// `said` says so. frame: its motors are judged beside the coordinates, each with what is said of
// it; of an error of the robot a motor that is harmed while another is helped is left out alike.
// With fewer than 20 judging rows nothing is judged.
std::vector<Harmful> withdraw_what_harms(const Problem& problem, const std::vector<Cause>& causes,
                                         const std::optional<CoordinateFrame>& frame,
                                         Extension& extension, std::vector<std::string>& said);

// Of the mean square that the baseline leaves on held-out rows beyond their own noise, the share
// that is left with all findings in: over all outputs, each in units of its noise. 1: no such rows,
// or nothing beyond the noise.
double share_left_held_out(const Problem& problem, const Extension& extension);

}  // namespace driftwise::diagnosis
