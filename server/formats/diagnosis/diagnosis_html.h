#pragma once
// A diagnosis as a page to look at, to keep and to send: one self-contained HTML file, without
// script, with nothing fetched from anywhere, under a content security policy that allows its own
// style sheet and nothing else. What it shows: docs/diagnosis-report.md.

#include <string>

#include "server/core/data/dataset.h"
#include "server/diagnosis/answer/diagnosis.h"

namespace driftwise::formats {

struct DiagnosisPage {
  std::string title;   // "Diagnosis of run 17"
  std::string source;  // where the rows are from: "drift.csv", "runs 16 and 17"
};

// dataset: the rows that were diagnosed, for time and positions. Works without times: then the
// rows' numbers stand for them. The text is UTF-8.
std::string diagnosis_html(const diagnosis::Diagnosis& diagnosis, const Dataset& dataset,
                           const DiagnosisPage& page);

}  // namespace driftwise::formats
