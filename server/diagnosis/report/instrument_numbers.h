#pragma once
// The numbers of an instrument's error, as the instrument has it: what it shows less what is true,
// in the unit of the coordinate that it measures. Where the motors are the outputs and the baseline
// reads that coordinate, their readings have the error with the opposite sign, through their slope
// along it: a lead of 2 doubles it, and a motor that turns has it as an angle.

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "server/diagnosis/growth/extension.h"

namespace driftwise::diagnosis {

// Of each output along a pose coordinate, by the baseline's linear term of it: summary unit per
// unit of the coordinate. Nothing where the baseline has none.
std::optional<Eigen::VectorXd> slopes_along(const Problem& problem, const std::string& symbol);

// The name that a number has in a finding: "further2_nm_per_h", "ppm_per_h_x". value: of the
// named's values; terms: that one value has.
std::string number_name(std::size_t value, const std::string& name, const effects::Term& term,
                        std::size_t terms);

// One number per term that has one, of all outputs together, each by its error. axis: the
// coordinate that is measured. coefficients, errors: terms x outputs, summary unit of the output
// per unit of the term; an output whose error is not above 0 says nothing. Nothing where the
// outputs measure: their own coefficients are the instrument's.
std::optional<std::vector<FoundParameter>> instrument_numbers(
    const Problem& problem, const Cause& cause, const Named& named, const std::string& axis,
    const Eigen::MatrixXd& coefficients, const Eigen::MatrixXd& errors);

}  // namespace driftwise::diagnosis
