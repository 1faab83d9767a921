#pragma once
// What `driftwise diagnose` prints: driftwise.diagnosis.v1 (DESIGN.md section 4) for programs, a
// page for people.

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "server/diagnosis/answer/diagnosis.h"

namespace driftwise::formats {

nlohmann::ordered_json diagnosis_json(const diagnosis::Diagnosis& diagnosis);
std::string diagnosis_page(const diagnosis::Diagnosis& diagnosis);

}  // namespace driftwise::formats
