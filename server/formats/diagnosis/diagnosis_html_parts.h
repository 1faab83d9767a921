#pragma once
// Sections of the diagnosis' page (diagnosis_html.h); each gives a piece of HTML, "" for nothing to
// say.

#include <string>

#include "server/core/data/dataset.h"
#include "server/diagnosis/answer/diagnosis.h"

namespace driftwise::formats {

// "84.2 nm"
std::string sized(double value, const std::string& unit);

std::string discrepancy_section(const diagnosis::OutputSummary& output, const Dataset& dataset,
                                bool opened);
std::string goes_with_section(const diagnosis::Diagnosis& diagnosis);
std::string ranking_section(const diagnosis::Diagnosis& diagnosis);
std::string finding_section(const diagnosis::Finding& finding, std::size_t number);
std::string rest_section(const diagnosis::Diagnosis& diagnosis);  // what is left, warnings
std::string not_testable_section(const diagnosis::Diagnosis& diagnosis);
std::string separating_section(const diagnosis::Diagnosis& diagnosis);

}  // namespace driftwise::formats
