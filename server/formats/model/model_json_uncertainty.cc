#include "server/formats/model/model_json_uncertainty.h"

#include <string>

#include "server/formats/text/text.h"

namespace driftwise::formats {
namespace {

using Json = nlohmann::ordered_json;

Json influence_json(const calibration::Influence& influence) {
  return {{"channel", influence.channel},
          {"by", influence.by},
          {"rms", json_number(influence.rms)},
          {"shift", std::vector<double>(influence.shift.begin(), influence.shift.end())}};
}

calibration::Influence read_influence(const JsonPlace& from, std::size_t moved) {
  calibration::Influence influence{.channel = from["channel"].text(),
                                   .by = from["by"].text(),
                                   .rms = from["rms"].finite(),
                                   .shift = {}};
  const auto shift = from["shift"];
  if (shift.size() != moved)
    shift.refuse(std::to_string(moved) + " numbers, one per term or free parameter");
  influence.shift.resize(static_cast<Eigen::Index>(moved));
  for (std::size_t k = 0; k < moved; ++k)
    influence.shift[static_cast<Eigen::Index>(k)] = shift[k].finite();
  return influence;
}

}  // namespace

Json matrix_json(const Eigen::MatrixXd& matrix) {
  Json out = Json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    Json row = Json::array();
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) row.push_back(matrix(i, j));
    out.push_back(std::move(row));
  }
  return out;
}

Eigen::MatrixXd read_matrix(const JsonPlace& from, std::size_t count) {
  if (from.size() != count) from.refuse(std::to_string(count) + " rows, one per term");
  for (std::size_t i = 0; i < count; ++i)
    if (from[i].size() != count) from[i].refuse(std::to_string(count) + " numbers, one per term");
  Eigen::MatrixXd out(static_cast<Eigen::Index>(count), static_cast<Eigen::Index>(count));
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t j = 0; j < count; ++j)
      out(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = from[i][j].finite();
  return out;
}

Json influences_json(const std::vector<calibration::Influence>& influences) {
  auto out = Json::array();
  for (const auto& influence : influences) out.push_back(influence_json(influence));
  return out;
}

std::vector<calibration::Influence> read_influences(const JsonPlace& from, std::size_t moved) {
  std::vector<calibration::Influence> out;
  for (std::size_t i = 0; i < from.size(); ++i) out.push_back(read_influence(from[i], moved));
  return out;
}

void write_uncertainty(const calibration::OutputModel& output, Json& out) {
  if (output.covariance_serial.size() > 0)
    out["covariance_serial"] = matrix_json(output.covariance_serial);
  if (output.covariance_root.size() > 0)
    out["covariance_root"] = matrix_json(output.covariance_root);
  if (output.noise_variance > 0) out["noise_variance"] = output.noise_variance;
  if (!output.influences.empty()) out["influences"] = influences_json(output.influences);
}

void read_uncertainty(const JsonPlace& from, std::size_t terms, calibration::OutputModel& output) {
  if (from.has("covariance_serial"))
    output.covariance_serial = read_matrix(from["covariance_serial"], terms);
  if (from.has("covariance_root"))  // models stored before have none
    output.covariance_root = read_matrix(from["covariance_root"], terms);
  if (from.has("noise_variance")) output.noise_variance = from["noise_variance"].finite();
  if (from.has("influences")) output.influences = read_influences(from["influences"], terms);
}

}  // namespace driftwise::formats
