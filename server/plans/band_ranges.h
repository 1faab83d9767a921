#pragma once
// Ranges of a model's inputs, as the check of a band and its poses read them.

#include "server/compensation/snapshot.h"

namespace driftwise::plans {

struct Range {
  double min = 0, max = 0;
};

// Fitted range of an input; 0 to 0: the model has no such input.
inline Range range_of(const compensation::Snapshot& model, compensation::Variable variable) {
  for (const auto& input : model.inputs)
    if (input.variable == variable) return {input.min, input.max};
  return {};
}

inline bool is_rotation(compensation::Variable variable) {
  return variable >= compensation::Variable::rx && variable <= compensation::Variable::rz;
}

}  // namespace driftwise::plans
