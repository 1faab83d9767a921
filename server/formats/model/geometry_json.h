#pragma once
// The geometry of a model as JSON: its robot file, what was identified, the covariance. Only for
// model_json.cc.

#include "server/calibration/model/model.h"
#include "server/formats/text/json_place.h"

namespace driftwise::formats {

nlohmann::ordered_json geometry_json(const calibration::Geometry& geometry);
// Throws JsonProblem, also for a robot file that cannot be read.
calibration::Geometry read_geometry(const JsonPlace& from);

}  // namespace driftwise::formats
