#pragma once
// Diagnosis of a data set with a baseline, 99 series of noise against chance, and its names.

#include <stdexcept>
#include <string>
#include <vector>

#include "server/diagnosis/diagnose.h"
#include "server/formats/formula/formula.h"

namespace driftwise::diagnosis {

inline Diagnosis diagnosed(const Dataset& data, const std::string& formula) {
  DiagnoseOptions options;
  options.baseline = *formats::Formula::parse(formula)->expand(data);
  options.nulls = 99;
  auto found = diagnose(data, options);
  if (!found) throw std::runtime_error(found.error().message);
  return *found;
}

inline std::vector<std::string> names_found(const Diagnosis& found) {
  std::vector<std::string> names;
  for (const auto& finding : found.findings)
    names.push_back(finding.cause + (finding.subject.empty() ? "" : " " + finding.subject));
  return names;
}

}  // namespace driftwise::diagnosis
