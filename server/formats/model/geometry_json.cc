#include "server/formats/model/geometry_json.h"

#include <algorithm>

#include "server/formats/cell_file/kinematics_section.h"
#include "server/formats/model/model_json_uncertainty.h"

namespace driftwise::formats {

nlohmann::ordered_json geometry_json(const calibration::Geometry& geometry) {
  // As in every model's JSON: a member that is forgotten here does not compile.
  const auto& [robot, all, covariance, influences] = geometry;
  auto parameters = nlohmann::ordered_json::array();
  for (const auto& [name, value, standard_error, free, note] : all)
    parameters.push_back({{"name", name},
                          {"value", value},
                          {"standard_error", json_number(standard_error)},
                          {"free", free},
                          {"note", note}});
  nlohmann::ordered_json out = {{"robot", write_robot_file(robot)},
                                {"parameters", std::move(parameters)},
                                {"covariance", matrix_json(covariance)}};
  if (!influences.empty()) out["influences"] = influences_json(influences);
  return out;
}

calibration::Geometry read_geometry(const JsonPlace& from) {
  calibration::Geometry geometry;
  auto robot = parse_robot_file(from["robot"].text(), "robot");
  if (!robot) from["robot"].refuse("a robot file: " + robot.error().message);
  geometry.robot = std::move(*robot);
  const auto parameters = from["parameters"];
  for (std::size_t i = 0; i < parameters.size(); ++i)
    geometry.parameters.push_back({.name = parameters[i]["name"].text(),
                                   .value = parameters[i]["value"].finite(),
                                   .standard_error = parameters[i]["standard_error"].number(),
                                   .free = parameters[i]["free"].truth(),
                                   .note = parameters[i]["note"].text()});
  const auto free =
      std::ranges::count(geometry.parameters, true, &calibration::GeometryParameter::free);
  geometry.covariance = read_matrix(from["covariance"], static_cast<std::size_t>(free));
  if (from.has("influences"))
    geometry.influences = read_influences(from["influences"], static_cast<std::size_t>(free));
  return geometry;
}

}  // namespace driftwise::formats
