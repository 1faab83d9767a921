#pragma once
// What `driftwise fit` prints: JSON for programs (schema driftwise.fit.v1, DESIGN.md section 4) and
// a page for people.

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "server/calibration/model/model.h"
#include "server/core/data/accuracy.h"

namespace driftwise::formats {

// Coefficients in the units of the columns; summaries in nm (lengths), arcsec (angles) or the
// output's own unit, which is named in each key. Numbers are written so that they read back
// exactly. covariance: of the coefficients in, in the order of the terms in.
nlohmann::ordered_json fit_json(const calibration::Model& model);

// [{"output": "q1", "rows": "validation", "a90_nm": .., "mean_nm": .., "u90_nm": ..}]: the accuracy
// that heads a page, one per unit; "before" where it is compared.
nlohmann::ordered_json heading_json(const std::vector<JudgedAccuracy>& heading);

struct FitTableOptions {
  bool history = false;  // step by step
  bool all = true;       // the terms left out as well
};
std::string fit_table(const calibration::Model& model, const FitTableOptions& options = {});

}  // namespace driftwise::formats
