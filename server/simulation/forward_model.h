#pragma once
// The cell run forward: the pose that the instruments should read, given motor coordinates and the
// present slow conditions. The calibrated model is the inverse geometric one, q = f(pose;
// temperatures, ...); this solves it for the pose by Newton's method.

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "server/calibration/model/model.h"
#include "server/core/result.h"
#include "server/effects/term_evaluator.h"

namespace driftwise::simulation {

// One thread; carries the memory of the model's effects, so readings come in time order. A copy
// forks it.
class ForwardModel {
 public:
  // symbols: the table of channels that values come in, as in TermEvaluator; it must hold every
  // channel the model reads. Errors: failed_precondition NOT_SQUARE (as many outputs as pose axes
  // in use are needed); those of TermEvaluator::create.
  static Result<ForwardModel> create(const calibration::Model& model,
                                     const std::vector<std::string>& symbols);

  // The pose axes it solves for, in order ("x", "y", ...), and the motor coordinates it starts from
  // ("q1", ...).
  const std::vector<std::string>& pose_symbols() const { return pose_symbols_; }
  const std::vector<std::string>& motor_symbols() const { return motor_symbols_; }

  // q: motor coordinates in the model's units, in order of motor_symbols(). values: one per symbol;
  // what stands at the pose axes is the first guess (NaN: the middle of the fitted domain). Result:
  // the pose in the model's units, in order of pose_symbols(). Errors: invalid_argument
  // MISSING_VALUE (a slow channel is NaN); failed_precondition NO_CONVERGENCE (singular or far
  // away: says where).
  Result<Eigen::VectorXd> step(double time_s, std::span<const double> q,
                               std::span<const double> values);

 private:
  ForwardModel() = default;
  Result<Eigen::VectorXd> model_at(const effects::TermEvaluator& memory, double time_s,
                                   std::vector<double>& values, const Eigen::VectorXd& pose) const;

  std::vector<std::string> pose_symbols_, motor_symbols_;
  std::vector<std::size_t> pose_columns_;
  std::vector<double> middle_, half_range_;
  std::vector<std::pair<std::size_t, Eigen::VectorXd>>
      outputs_;                                    // first column of each output, its coefficients
  std::vector<effects::TermEvaluator> evaluator_;  // one, in a vector because it has no empty state
};

}  // namespace driftwise::simulation
