#pragma once
// Motor coordinates of the two robots of an indentation: of the serving plan, or of nominal
// geometry. Moves nothing. One thread.

#include <map>
#include <string>

#include "clients/cli/core/connection.h"
#include "server/formats/indentation/indentation_file.h"

namespace driftwise::v1 {
class JointTarget;
}

namespace driftwise::cli {

// The tool of the robot above in its frame; tilts and height of the robot below.
struct IndentPose {
  double x_mm = 0, y_mm = 0, z_mm = 0;
  double rx_arcsec = 0, ry_arcsec = 0, height_mm = 0;
};

using Motors = std::map<std::string, double>;  // "mn.q1_mm" -> mm

// "plan 1, mn=5, ma=coarse:1 OUTSIDE_DOMAIN(t19_degC)": each robot with the models that answered.
std::string answered_by(const v1::JointTarget& target);

class IndentMotors {
 public:
  IndentMotors(const Connection& connection, const formats::IndentationFile& file)
      : connection_(connection), file_(file) {}

  // Of this robot of the file. Errors: those of ComputeJointTarget; invalid_argument OUTSIDE_DOMAIN
  // (the arms of the robot above do not reach the place).
  Result<Motors> of(const std::string& robot, const IndentPose& pose);
  // The last answer's source: "plan 1, mn=5, ma=coarse:1", "geometry, raw motor coordinates: ...".
  const std::string& by() const { return by_; }
  // Source of its heights: "plan 1", "geometry".
  const std::string& source() const { return source_; }

 private:
  Result<Motors> by_geometry(const std::string& robot, const IndentPose& pose) const;

  const Connection& connection_;
  const formats::IndentationFile& file_;
  std::string by_, source_;
};

Error error_of(const Failure& failure);

}  // namespace driftwise::cli
