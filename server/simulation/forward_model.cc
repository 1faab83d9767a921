#include "server/simulation/forward_model.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/effects/term_order.h"

namespace driftwise::simulation {
namespace {

constexpr int kMaxIterations = 50;
constexpr double kNewtonTolerance =
    1e-13;                              // of the half range: far below a nanometre over millimetres
constexpr double kJacobianStep = 1e-6;  // of the half range; central differences

}  // namespace

Result<ForwardModel> ForwardModel::create(const calibration::Model& model,
                                          const std::vector<std::string>& symbols) {
  ForwardModel forward;
  std::vector<effects::Term> terms;
  for (const auto& output : model.outputs) {
    forward.motor_symbols_.push_back(output.channel.symbol);
    forward.outputs_.emplace_back(terms.size(), output.coefficients);
    terms.insert(terms.end(), output.terms.begin(), output.terms.end());
  }
  for (const auto& range : model.domain) {
    if (!is_pose_symbol(range.channel.symbol)) continue;
    const auto column = std::ranges::find(symbols, range.channel.symbol);
    if (column == symbols.end()) continue;  // the evaluator names what is missing
    forward.pose_symbols_.push_back(range.channel.symbol);
    forward.pose_columns_.push_back(static_cast<std::size_t>(column - symbols.begin()));
    forward.middle_.push_back(0.5 * (range.min + range.max));
    forward.half_range_.push_back(
        std::max(0.5 * (range.max - range.min), std::numeric_limits<double>::min()));
  }
  DRIFTWISE_TRY(auto evaluator, effects::TermEvaluator::create(terms, symbols));
  if (forward.pose_symbols_.size() != model.outputs.size())
    return fail(ErrorCode::failed_precondition, reasons::kNotSquare,
                "to run a model forward it needs as many outputs as pose axes: '" + model.formula +
                    "' has " + std::to_string(model.outputs.size()) + " outputs and " +
                    std::to_string(forward.pose_symbols_.size()) + " pose axes");
  forward.evaluator_.push_back(std::move(evaluator));
  return forward;
}

Result<Eigen::VectorXd> ForwardModel::model_at(const effects::TermEvaluator& memory, double time_s,
                                               std::vector<double>& values,
                                               const Eigen::VectorXd& pose) const {
  for (std::size_t i = 0; i < pose_columns_.size(); ++i)
    values[pose_columns_[i]] = pose[static_cast<Eigen::Index>(i)];
  std::vector<double> columns(memory.columns());
  effects::TermEvaluator trial = memory;  // a look ahead must not advance the memory
  trial.step(time_s, values, columns);
  Eigen::VectorXd q(static_cast<Eigen::Index>(outputs_.size()));
  for (std::size_t i = 0; i < outputs_.size(); ++i) {
    const auto& [first, coefficients] = outputs_[i];
    q[static_cast<Eigen::Index>(i)] = coefficients.dot(
        Eigen::Map<const Eigen::VectorXd>(columns.data() + first, coefficients.size()));
  }
  if (!q.allFinite())
    return fail(ErrorCode::invalid_argument, reasons::kMissingValue,
                "a channel that the model reads has no value at this reading");
  return q;
}

Result<Eigen::VectorXd> ForwardModel::step(double time_s, std::span<const double> q,
                                           std::span<const double> values) {
  effects::TermEvaluator& memory = evaluator_.front();
  std::vector<double> row(values.begin(), values.end());
  const auto n = static_cast<Eigen::Index>(pose_symbols_.size());
  Eigen::VectorXd pose(n), half_range(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double guess = row[pose_columns_[k]];
    pose[i] = std::isfinite(guess) ? guess : middle_[k];
    half_range[i] = half_range_[k];
  }
  const Eigen::Map<const Eigen::VectorXd> wanted(q.data(), static_cast<Eigen::Index>(q.size()));
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    DRIFTWISE_TRY(const auto at, model_at(memory, time_s, row, pose));
    Eigen::MatrixXd jacobian(n, n);
    for (Eigen::Index j = 0; j < n; ++j) {
      Eigen::VectorXd up = pose, down = pose;
      up[j] += kJacobianStep * half_range[j];
      down[j] -= kJacobianStep * half_range[j];
      const auto high = model_at(memory, time_s, row, up),
                 low = model_at(memory, time_s, row, down);
      if (!high || !low) return tl::unexpected((high ? low : high).error());
      jacobian.col(j) = (*high - *low) / (up[j] - down[j]);
    }
    const Eigen::VectorXd change = jacobian.partialPivLu().solve(wanted - at);
    if (!change.allFinite()) break;
    pose += change;
    if ((change.cwiseAbs().array() <=
         kNewtonTolerance * half_range.array().max(pose.cwiseAbs().array()))
            .all()) {
      for (Eigen::Index i = 0; i < n; ++i)
        row[pose_columns_[static_cast<std::size_t>(i)]] = pose[i];
      std::vector<double> columns(memory.columns());
      memory.step(time_s, row, columns);
      return pose;
    }
  }
  return fail(ErrorCode::failed_precondition, reasons::kNoConvergence,
              "no pose gives these motor coordinates by the model (last try " +
                  pose_symbols_.front() + " = " + effects::number_text(pose[0]) +
                  "): is the row far outside the fitted domain?");
}

}  // namespace driftwise::simulation
