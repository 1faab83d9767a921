#pragma once
// Version 6: configurations in force, pending stops, suspect points, verification of the record.
// Never edited once released; a later change is a new version with its own text.

#include <string_view>

namespace driftwise::storage {

constexpr std::string_view kSchemaV6 =
    R"sql(
-- Each subject below is independent of the others.

-- Gains of an improvement: mean and A90 with every U90, and the model before on the fresh points.
ALTER TABLE improvement_gain ADD COLUMN mean_before REAL;
ALTER TABLE improvement_gain ADD COLUMN a90_before REAL;
ALTER TABLE improvement_gain ADD COLUMN mean_predicted REAL;
ALTER TABLE improvement_gain ADD COLUMN a90_predicted REAL;
ALTER TABLE improvement_gain ADD COLUMN u90_measured_before REAL;
ALTER TABLE improvement_gain ADD COLUMN mean_measured_before REAL;
ALTER TABLE improvement_gain ADD COLUMN a90_measured_before REAL;
ALTER TABLE improvement_gain ADD COLUMN mean_measured REAL;
ALTER TABLE improvement_gain ADD COLUMN a90_measured REAL;
)sql";

}  // namespace driftwise::storage
