#pragma once
// Diagnosis of a data set with a baseline, 99 series of noise against chance.

#include <stdexcept>
#include <string>

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

}  // namespace driftwise::diagnosis
