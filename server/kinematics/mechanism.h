#pragma once
// A robot's geometry with parameters that can be identified: what its drawing says, evaluated.
//
// A mechanism predicts its outputs from its inputs in the direction that has a closed form, which
// is also the one its calibration is stated in: a delta or a linear axis gives motor coordinates
// from the measured pose (the inverse geometric model), a serial arm gives the measured pose from
// the joint angles (the direct one). Frames, signs and sources: docs/kinematics.md.

#include <Eigen/Core>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "server/core/description/kinematics_description.h"
#include "server/core/result.h"
#include "server/kinematics/parameter.h"

namespace driftwise::kinematics {

constexpr int kMostOutputs = 6;
constexpr int kMostParameters = 64;

struct Prediction {
  // In the channels' units; NaN where no configuration reaches the pose.
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostOutputs, 1> value;
  // Outputs x parameters, per unit of each parameter; 0 x 0 when it was not asked for.
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostOutputs, kMostParameters> jacobian;
};

enum class Derivatives { no, yes };

// Immutable; any thread.
class Mechanism {
 public:
  virtual ~Mechanism() = default;

  const KinematicsDescription& description() const { return description_; }
  const Parameters& parameters() const { return parameters_; }
  const std::vector<Channel>& inputs() const { return inputs_; }    // x_mm, y_mm, z_mm
  const std::vector<Channel>& outputs() const { return outputs_; }  // q1_mm, q2_mm, q3_mm
  // True where the outputs are the pose (a serial arm).
  bool predicts_pose() const { return is_pose_symbol(outputs_.front().symbol); }

  // inputs: one value per input channel; values: one per parameter, in its unit.
  Prediction predict(std::span<const double> inputs, const Eigen::VectorXd& values,
                     Derivatives derivatives = Derivatives::no) const {
    return evaluate(inputs, values, derivatives);
  }

 protected:
  explicit Mechanism(KinematicsDescription description) : description_(std::move(description)) {}

  KinematicsDescription description_;
  Parameters parameters_;
  std::vector<Channel> inputs_, outputs_;

 private:
  virtual Prediction evaluate(std::span<const double> inputs, const Eigen::VectorXd& values,
                              Derivatives derivatives) const = 0;
};

// Errors, invalid_argument: BAD_KINEMATICS (unknown kind, number of branches or links, an arm too
// short for its radius, units that do not fit); UNKNOWN_PARAMETER in hold.
Result<std::shared_ptr<const Mechanism>> make_mechanism(const KinematicsDescription& description);

}  // namespace driftwise::kinematics
