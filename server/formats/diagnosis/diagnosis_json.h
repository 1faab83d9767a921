#pragma once
// What `driftwise diagnose` prints: driftwise.diagnosis.v1 (DESIGN.md section 4) for programs, a
// page for people.

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "server/correction/data_amendment.h"
#include "server/diagnosis/answer/diagnosis.h"

namespace driftwise::formats {

// origins: run and row of its plan by place in the dataset; the rows of a finding are then rows of
// the plan, of the runs in `row_runs`. Empty: rows of a file, by their place.
nlohmann::ordered_json diagnosis_json(const diagnosis::Diagnosis& diagnosis,
                                      const std::vector<correction::RowOrigin>& origins = {});
std::string diagnosis_page(const diagnosis::Diagnosis& diagnosis);

}  // namespace driftwise::formats
