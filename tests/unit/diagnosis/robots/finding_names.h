#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "server/diagnosis/answer/diagnosis.h"

namespace driftwise::diagnosis {

using Names = std::vector<std::string>;

// Cause and subject of every finding, sorted.
inline Names names(const Diagnosis& diagnosis) {
  Names all;
  for (const auto& finding : diagnosis.findings)
    all.push_back(finding.cause + " " + finding.subject);
  std::ranges::sort(all);
  return all;
}

}  // namespace driftwise::diagnosis
