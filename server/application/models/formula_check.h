#pragma once
// What a formula offers on a dataset and what of it the rows can tell apart: the fit's own parser,
// design and rank, without the fit. For whoever types a formula and wants to know while typing.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/application/models/fit_request.h"
#include "server/core/channel.h"
#include "server/core/data/dataset.h"

namespace driftwise::application {

// Terms that a formula offers on some data, without a fit.
struct FormulaCheck {
  std::string problem;                        // with the place marked; empty: it can be fitted
  std::optional<std::size_t> problem_offset;  // bytes into the formula, where the text is at fault
  std::string canonical;
  std::vector<std::string> outputs, terms;  // symbols; notation, without the constant
  std::int64_t calibration = 0, validation = 0, dropped = 0;  // rows
  int rank = 0, columns = 0;
  std::vector<std::string> look_alikes;  // sentences
  std::vector<Channel> channels;         // of the data
};

// Pure. Errors: none of the formula's: they are the problem of the answer. The request's runs and
// csv are not looked at: dataset is what they hold.
FormulaCheck check_formula_on(const Dataset& dataset, const FitRequest& request);

}  // namespace driftwise::application
