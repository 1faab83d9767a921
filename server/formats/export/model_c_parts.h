#pragma once
// The exported model in two parts, as serving has it: q = c' (S b).
//
// Slow part, every few seconds: ..._fold(temperatures, folded) computes S' c, one number per output
// and product of the pose. Fast part, per target: ..._fast(folded, pose, q) is one short polynomial
// in the pose; ..._fast_from(zero, folded, pose, q) the same from another zero. The sums are in
// another order than in the function of one part: q differs from it by rounding, less than 1e-6 nm.

#include <string>

#include "server/calibration/model/model.h"
#include "server/formats/export/model_c_text.h"

namespace driftwise::formats {

// function: "driftwise_model_axis". Terms of datum are left out, as in the function of one part.
std::string model_c_parts(const calibration::Model& model, const std::string& function,
                          const CInputs& inputs);

}  // namespace driftwise::formats
