#pragma once
// A finding as a person would say it.

#include <string>

#include "server/diagnosis/answer/finding.h"
#include "server/diagnosis/rows/screen.h"

namespace driftwise::diagnosis {

std::string sentence(const Finding& finding);
// first_row: name of the first of its rows, "row 17".
std::string sentence(const FaultySensor& sensor, const std::string& first_row);
std::string size_text(double value, const std::string& unit);  // three digits: "84.2 nm"

// Periods that the places cannot tell from the finding's; empty where there are none.
std::string aliases_note(const Finding& finding);

// Of a finding whose terms follow what the baseline predicts: no formula of that output can have
// them. Empty where there are none.
std::string follows_an_output_note(const Finding& finding, const std::vector<std::string>& outputs);

}  // namespace driftwise::diagnosis
