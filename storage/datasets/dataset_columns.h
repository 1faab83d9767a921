#pragma once
// In which order a dataset shows its channels.

#include <string>
#include <vector>

#include "server/core/channel.h"

namespace driftwise::storage {

// Motor coordinates as read back (q1, q2, ..), commanded (q1_cmd, ..), pose (x y z rx ry rz),
// standard deviations of repeats (x_std, ..), structure temperatures (t01, ..), then the others;
// each kind by number or as it came.
void sort_as_dataset(std::vector<Channel>& channels);

}  // namespace driftwise::storage
