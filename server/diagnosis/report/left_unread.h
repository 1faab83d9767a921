#pragma once
// Sentences on what a diagnosis was given and does not read.

#include <string>

#include "server/diagnosis/rows/problem.h"
#include "server/kinematics/mechanism.h"

namespace driftwise::diagnosis {

// Of a term of problem.undetermined: why it is left out. A channel is constant; or it is so far
// from zero that its powers are alike, with what to subtract.
std::string undetermined_note(const Problem& problem, const effects::Term& term);

// Of the pose coordinates that the file of an arm has and its drawing does not predict. Empty:
// none.
std::string unread_pose_note(const Dataset& dataset, const kinematics::Mechanism& mechanism);

}  // namespace driftwise::diagnosis
