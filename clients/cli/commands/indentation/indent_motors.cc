#include "clients/cli/commands/indentation/indent_motors.h"

#include <cmath>

#include "driftwise/v1/plan_service.grpc.pb.h"
#include "server/core/reasons.h"
#include "server/core/text/shown_text.h"
#include "server/core/units.h"

namespace driftwise::cli {

std::string answered_by(const v1::JointTarget& target) {
  std::string text = "plan " + std::to_string(target.plan_id());
  for (const auto& robot : target.robots()) {
    const std::string fine = std::to_string(robot.model_id()),
                      coarse = std::to_string(robot.coarse_model_id());
    text += ", " + robot.robot() + "=" +
            (robot.by() == v1::RobotAnswer::BY_COARSE  ? "coarse:" + coarse
             : robot.by() == v1::RobotAnswer::BY_FINE  ? "fine:" + fine
             : robot.by() == v1::RobotAnswer::BY_BLEND ? "blend:" + fine + "+" + coarse
                                                       : fine);
  }
  for (const auto& flag : target.flags()) text += " " + flag;
  return text;
}

Error error_of(const Failure& failure) {
  const ErrorCode code = failure.code == to_string(ErrorCode::aborted) ? ErrorCode::aborted
                         : failure.exit == ExitCode::unreachable       ? ErrorCode::unavailable
                         : failure.exit == ExitCode::bad_input         ? ErrorCode::invalid_argument
                                                               : ErrorCode::failed_precondition;
  return {code, failure.reason, failure.message};
}

// Vertical screws below, a delta with its carriages above: nominal sizes, no compensation.
Result<Motors> IndentMotors::by_geometry(const std::string& robot, const IndentPose& pose) const {
  Motors motors;
  for (std::size_t i = 0; i < 3; ++i) {
    double& motor_mm = motors[robot + ".q" + std::to_string(i + 1) + "_mm"];
    if (robot == file_.below) {
      const double a = file_.screws.azimuth_deg[i] * kRadPerDeg;
      motor_mm = pose.height_mm +
                 file_.screws.radius_mm * (std::sin(a) * std::tan(rad_from_arcsec(pose.rx_arcsec)) -
                                           std::cos(a) * std::tan(rad_from_arcsec(pose.ry_arcsec)));
      continue;
    }
    const auto& d = file_.delta;
    const double a = d.azimuth_deg[i] * kRadPerDeg;
    const double off_x = pose.x_mm - d.radius_mm * std::cos(a);
    const double off_y = pose.y_mm - d.radius_mm * std::sin(a);
    const double rise2_mm2 = d.arm_mm * d.arm_mm - off_x * off_x - off_y * off_y;
    if (!(rise2_mm2 > 0))
      return fail(ErrorCode::invalid_argument, reasons::kOutsideDomain,
                  "the arms of robot " + shown(robot) + " (arm_mm " + number_text(d.arm_mm) +
                      ") do not reach x " + number_text(pose.x_mm) + ", y " +
                      number_text(pose.y_mm) + " mm: check the places of the file, all in mm");
    motor_mm = pose.z_mm + std::sqrt(rise2_mm2) -
               std::sqrt(d.arm_mm * d.arm_mm - d.radius_mm * d.radius_mm);
  }
  return motors;
}

Result<Motors> IndentMotors::of(const std::string& robot, const IndentPose& pose) {
  if (!file_.by_plan) {
    source_ = "geometry";
    by_ = "geometry, raw motor coordinates: " + file_.reason;
    return by_geometry(robot, pose);
  }
  v1::ComputeJointTargetRequest request;
  const auto wanted = [&request](const std::string& channel, double value) {
    auto* one = request.add_pose();
    one->set_channel(channel);
    one->set_value(value);
  };
  wanted(file_.above + ".x_mm", pose.x_mm);
  wanted(file_.above + ".y_mm", pose.y_mm);
  wanted(file_.above + ".z_mm", pose.z_mm);
  wanted(file_.below + ".rx_arcsec", pose.rx_arcsec);
  wanted(file_.below + ".ry_arcsec", pose.ry_arcsec);
  wanted(file_.below + ".z_mm", pose.height_mm);
  try {
    const auto target =
        connection_.ask(&v1::PlanService::Stub::ComputeJointTarget, request).target();
    source_ = "plan " + std::to_string(target.plan_id());
    by_ = answered_by(target);
    Motors motors;
    for (const auto& one : target.coordinates())
      if (one.channel().starts_with(robot + ".")) motors[one.channel()] = one.position_mm();
    return motors;
  } catch (const Failure& failure) {
    return tl::unexpected(error_of(failure));
  }
}

}  // namespace driftwise::cli
