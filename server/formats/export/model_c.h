#pragma once
// A model as one C99 source file for controllers that want the model itself: no library, no
// allocation, no state.
//
//   int driftwise_model_<name>(const double *pose, const double *temperatures, double *q);
//
// pose, temperatures, q: arrays whose order and units stand in the file's head comment (pose holds
// what a request states, force included; temperatures every other channel). Of a robot with an id
// the names are without it ("x_mm" of "ma.x_mm"), and the head comment has the id. Returned: 0, or
// a bit per input outside the fitted domain, pose first. The arithmetic is that of
// effects::TermEvaluator, product by product in the same order: without contraction
// (-ffp-contract=off, the default of -std=c99 in GCC) the results are the same to the last bit. A
// target of the daemon sums in another order (compensation/snapshot.h): it differs by rounding, at
// most n eps times the sum of the n terms' sizes.
// Two further functions carry it to another zero, as serving does (docs/decisions/0005):
// ..._zero(pose, temperatures, q, zero) finds where that zero lies in the model's own datum,
// ..._from(zero, pose, temperatures, q) answers from there.
// Three functions do the same in a slow and a fast part: model_c_parts.h.
// With -DDRIFTWISE_MODEL_SELF_TEST the file has a main that runs the test vectors it carries and
// exits 0 or 1.

#include <string>

#include "server/calibration/model/model.h"
#include "server/core/result.h"

namespace driftwise::formats {

// name: a part of a C identifier (letters, digits, '_').
// Errors: invalid_argument, BAD_NAME; failed_precondition, NOT_EXPORTABLE, naming the term: an
// effect with memory is no function of the present values; a channel without its fitted range;
// channels of several robots.
Result<std::string> write_model_c(const calibration::Model& model, const std::string& name);

}  // namespace driftwise::formats
