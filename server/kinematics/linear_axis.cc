#include "server/kinematics/linear_axis.h"

#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::kinematics {

Result<Axis> Axis::create(const KinematicsDescription& description) {
  if (description.axes.size() != 1)
    return fail(ErrorCode::invalid_argument, reasons::kBadKinematics,
                "kinematics: found " + std::to_string(description.axes.size()) +
                    " axes, expected one for a linear-axis");
  const LinearAxis& axis = description.axes.front();
  if (axis.motor.unit != "mm" || axis.pose.unit != "mm")
    return fail(ErrorCode::invalid_argument, reasons::kBadKinematics,
                "kinematics: found " + axis.motor.name() + " and " + axis.pose.name() +
                    ", expected both in mm");
  Axis made(description);
  made.inputs_ = {axis.pose};
  made.outputs_ = {axis.motor};
  made.parameters_ = {{"axis.offset_mm", axis.offset_mm, 1e-3, 0, true},
                      {"axis.scale_ppm", axis.scale_ppm, 100}};
  DRIFTWISE_RETURN_IF_ERROR(hold(made.parameters_, description.hold));
  return made;
}

Prediction Axis::evaluate(std::span<const double> inputs, const Eigen::VectorXd& values,
                          Derivatives derivatives) const {
  const double along = inputs[0] - values[0], gain = 1 + 1e-6 * values[1];
  Prediction prediction;
  prediction.value.resize(1);
  prediction.value[0] = along * gain;
  if (derivatives == Derivatives::no) return prediction;
  prediction.jacobian.resize(1, 2);
  prediction.jacobian << -gain, 1e-6 * along;
  return prediction;
}

}  // namespace driftwise::kinematics
