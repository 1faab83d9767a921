#pragma once
// The part of a model's JSON that its uncertainty is computed from: covariances and influences.
// Only for model_json.cc.

#include <cstddef>

#include "server/calibration/model/model.h"
#include "server/formats/text/json_place.h"

namespace driftwise::formats {

nlohmann::ordered_json matrix_json(const Eigen::MatrixXd& matrix);
// count x count, before room is made: the text itself bounds the memory. Throws JsonProblem.
Eigen::MatrixXd read_matrix(const JsonPlace& from, std::size_t count);

// covariance_serial, covariance_root, noise_variance, influences; each absent where the model has
// none, as one stored by 0.1 does. shift: as many numbers as what the influence moves, terms or
// parameters.
nlohmann::ordered_json influences_json(const std::vector<calibration::Influence>& influences);
std::vector<calibration::Influence> read_influences(const JsonPlace& from, std::size_t moved);

void write_uncertainty(const calibration::OutputModel& output, nlohmann::ordered_json& out);
void read_uncertainty(const JsonPlace& from, std::size_t terms, calibration::OutputModel& output);

}  // namespace driftwise::formats
