#pragma once
// Four ways from the same data to a model of the same robot, behind one pair of functions. What a
// method predicts are the channels on the left of the formula: motor coordinates from the pose, or
// for a serial arm the pose from the joint angles.
//
//   stepwise   the formula alone, by calibration::fit: no geometry is assumed
//   nominal    the drawing: only where the robot stands (an arm's frame) or reads zero is fitted
//   classic    nominal kinematics plus an error fitted by the formula (thesis 5098, eq. 1.6-1.9):
//              e_q = q - IGM(measured pose), e_q ~ formula, q = IGM + error
//   kinematic  the lengths and angles themselves by nonlinear least squares; of the formula only
//              what the geometry does not read (force, temperatures)

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/calibration/fit.h"
#include "server/identification/identify.h"

namespace driftwise::identification {

enum class Method { stepwise, nominal, classic, kinematic };

std::string name_of(Method method);
std::optional<Method> method_from(const std::string& name);
// All that can be had with a formula, a mechanism or both, the simplest first.
std::vector<Method> methods_possible(bool formula, bool mechanism);

struct MethodOptions {
  calibration::FitOptions fit;  // its candidates: what the formula says of this dataset; outputs
                                // and terms may be empty for nominal and kinematic
  std::shared_ptr<const kinematics::Mechanism> mechanism;  // not needed by stepwise
};

struct FittedMethod {
  Method method = Method::stepwise;
  std::vector<Channel> outputs;
  std::optional<Identification> kinematics;  // nominal, classic, kinematic
  std::optional<calibration::Model> linear;  // stepwise: the model; classic: of the error
  double fit_us = 0;

  int parameters() const;                    // all that were estimated
  int parameters(std::size_t output) const;  // those of one output; kinematic ones are shared
};

// On the rows marked calibration. Errors: those of calibration::fit and identify;
// invalid_argument NO_KINEMATICS (the method needs a mechanism), NO_FORMULA, OTHER_OUTPUTS (the
// formula's left side is not what the mechanism predicts).
Result<FittedMethod> fit_method(const Dataset& dataset, Method method,
                                const MethodOptions& options);

// rows x outputs over all rows, NaN where a value is missing.
Result<Eigen::MatrixXd> predict(const Dataset& dataset, const FittedMethod& fitted);

}  // namespace driftwise::identification
