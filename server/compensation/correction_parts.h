#pragma once
// What a correction is made of, for people: motor coordinate minus wanted coordinate, parted by
// what the terms read.
//
// geometry: terms of the pose alone with the constant, and the wanted coordinate taken off; force:
// terms with the force and nothing slow; temperatures: terms with anything slow, since the zero of
// the datum (or, in the model's own datum, from the middle of the fitted ranges, so that a
// coefficient times 23 degrees does not stand against the constant). Their sum is the correction.

#include <optional>

#include "server/compensation/snapshot.h"
#include "server/compensation/target.h"

namespace driftwise::compensation {

struct CorrectionParts {
  double geometry_nm = 0, force_nm = 0, temperatures_nm = 0;
  double sum_nm() const { return geometry_nm + force_nm + temperatures_nm; }
};

// None: the output has no wanted coordinate of its number (q2: y) in the request, or the request
// cannot be answered. Pure, any thread.
std::optional<CorrectionParts> correction_parts(const Snapshot& snapshot,
                                                const TargetRequest& request, std::size_t output);

}  // namespace driftwise::compensation
