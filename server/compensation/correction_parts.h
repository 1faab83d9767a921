#pragma once
// What a correction is made of, for people: motor coordinate minus what straight kinematics would
// give, parted by what the terms read.
//
// Straight kinematics: the wanted coordinate of the same number (q2: y) where the motor follows it,
// that is where the model's slope is within 5 % of 1 along it and of 0 along the others; else (a
// delta's motors follow no single coordinate) the model's own terms of first degree in the pose.
// geometry: what terms of the pose alone add to that; force: terms with the force and nothing slow;
// temperatures: terms with anything slow, since the zero of the datum (or, in the model's own
// datum, from the middle of the fitted ranges, so that a coefficient times 23 degrees does not
// stand against the constant). Their sum is the correction.

#include <optional>

#include "server/compensation/snapshot.h"
#include "server/compensation/target.h"

namespace driftwise::compensation {

struct CorrectionParts {
  double geometry_nm = 0, force_nm = 0, temperatures_nm = 0;
  double sum_nm() const { return geometry_nm + force_nm + temperatures_nm; }
};

// None: the request cannot be answered, the model reads no pose, or it has a geometry. Pure, any
// thread.
std::optional<CorrectionParts> correction_parts(const Snapshot& snapshot,
                                                const TargetRequest& request, std::size_t output);

}  // namespace driftwise::compensation
