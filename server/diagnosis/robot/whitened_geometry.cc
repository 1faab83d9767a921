#include "server/diagnosis/robot/whitened_geometry.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "server/calibration/design/predict.h"
#include "server/diagnosis/answer/u90.h"
#include "server/diagnosis/noise/ground.h"
#include "server/identification/pose_rows.h"
#include "server/kinematics/angles.h"

namespace driftwise::diagnosis {
namespace {

using Eigen::Index;

// Some rows of the robot, stacked by output, in summary units.
struct Stacked {
  Eigen::MatrixXd columns;  // parameters, linear terms of each output, joint turns
  Eigen::VectorXd left;     // measured minus the identified robot
};

// Column of the parameter that turns a joint.
std::vector<Index> joint_columns(const kinematics::Mechanism& mechanism, const JointTurns& turns) {
  std::vector<Index> columns;
  for (const std::size_t joint : turns.joint) {
    const std::string name = "link" + std::to_string(joint + 1) + ".theta_deg";
    const auto& all = mechanism.parameters();
    const auto found = std::ranges::find(all, name, &kinematics::Parameter::name);
    columns.push_back(static_cast<Index>(found - all.begin()));
  }
  return columns;
}

Stacked stacked(const Dataset& marked, const Problem& problem,
                const identification::Identification& identified,
                const std::vector<std::size_t>& rows, const JointTurns& turns) {
  const auto& mechanism = *identified.mechanism;
  const auto data = identification::mechanism_data(marked, mechanism);
  const Eigen::VectorXd values = identified.values();
  const auto n = static_cast<Index>(rows.size()), parameters = values.size();
  const auto outputs = static_cast<Index>(mechanism.outputs().size());
  const Index terms =
      identified.terms.empty() ? 0 : static_cast<Index>(identified.terms.size()) - 1;
  Eigen::MatrixXd linear;
  if (terms > 0) linear = *calibration::raw_columns(marked, identified.terms);
  const auto turning = joint_columns(mechanism, turns);
  const auto shapes = static_cast<Index>(turning.size());
  Stacked all{Eigen::MatrixXd::Zero(outputs * n, parameters + outputs * terms + shapes),
              Eigen::VectorXd(outputs * n)};
  for (Index i = 0; i < n; ++i) {
    const auto row = static_cast<Index>(rows[static_cast<std::size_t>(i)]);
    const Eigen::VectorXd input = data->inputs.col(row);
    const auto at = mechanism.predict({input.data(), static_cast<std::size_t>(input.size())},
                                      values, kinematics::Derivatives::yes);
    for (Index o = 0; o < outputs; ++o) {
      const double factor = problem.outputs[static_cast<std::size_t>(o)].factor;
      double predicted = at.value[o];
      if (terms > 0) predicted += linear.row(row).dot(identified.coefficients.col(o));
      all.left[o * n + i] = factor * (data->outputs(row, o) - predicted);
      all.columns.row(o * n + i).head(parameters) = factor * at.jacobian.row(o);
      if (terms > 0)
        all.columns.row(o * n + i).segment(parameters + o * terms, terms) =
            factor * linear.row(row).tail(terms);
      for (Index k = 0; k < shapes; ++k)
        all.columns(o * n + i, all.columns.cols() - shapes + k) =
            factor * kinematics::deg_from_rad(turns.rad(row, k)) *
            at.jacobian(o, turning[static_cast<std::size_t>(k)]);
    }
  }
  return all;
}

// Deviations of what was identified from the drawing; 0 for where the robot stands.
Eigen::VectorXd deviations(const identification::Identification& identified, Index columns) {
  Eigen::VectorXd all = Eigen::VectorXd::Zero(columns);
  for (std::size_t k = 0; k < identified.parameters.size(); ++k) {
    const auto& one = identified.parameters[k];
    if (!one.parameter.placement) all[static_cast<Index>(k)] = one.value - one.parameter.nominal;
  }
  return all;
}

// Each row of outputs freed of the correlation between them: white times L^-T, R = L L'.
void decorrelate(const Eigen::MatrixXd& lower, Index n, Eigen::Ref<Eigen::VectorXd> stacked) {
  Eigen::Map<Eigen::MatrixXd> by_output(stacked.data(), n, lower.rows());
  by_output =
      lower.triangularView<Eigen::Lower>().solve(by_output.transpose().eval()).transpose().eval();
}

}  // namespace

WhitenedGeometry plain_geometry(const Dataset& marked, const Problem& problem,
                                const identification::Identification& identified,
                                const JointTurns& turns) {
  const auto learn = stacked(marked, problem, identified, problem.learn, turns);
  const auto judge = stacked(marked, problem, identified, problem.judge, turns);
  const Eigen::VectorXd back = deviations(identified, learn.columns.cols());
  const Eigen::VectorXd y = learn.left + learn.columns * back;
  return {learn.columns, y, learn.columns, judge.columns, judge.left + judge.columns * back};
}

std::optional<WhitenedGeometry> whitened_geometry(const Dataset& marked, const Problem& problem,
                                                  const identification::Identification& identified,
                                                  const std::vector<NoiseShape>& shapes,
                                                  const std::function<bool()>& tick) {
  WhitenedGeometry result = plain_geometry(marked, problem, identified);
  const Eigen::VectorXd back = deviations(identified, result.columns.cols());
  result.y -= result.columns * back;
  const auto n = static_cast<Index>(problem.learn.size());
  const auto outputs = static_cast<Index>(problem.outputs.size());
  for (Index o = 0; o < outputs; ++o) {
    auto columns = result.columns.middleRows(o * n, n);
    auto y = result.y.segment(o * n, n);
    const Ground ground(problem.timeline, shapes, Eigen::MatrixXd(columns), y, tick);
    if (ground.shape_count() < shapes.size()) return std::nullopt;
    const auto& space = ground.space(ground.best_shape(0), 0);
    const double sd = ground.white_sd(0).value;
    space.whiten(columns);
    space.whiten(y);
    columns /= sd;
    y /= sd;
  }
  const Eigen::MatrixXd white = result.y.reshaped(n, outputs);
  Eigen::MatrixXd correlation = white.transpose() * white / static_cast<double>(n);
  const Eigen::VectorXd sd = correlation.diagonal().cwiseSqrt();
  correlation = sd.cwiseInverse().asDiagonal() * correlation * sd.cwiseInverse().asDiagonal();
  const Eigen::MatrixXd lower = correlation.llt().matrixL();
  decorrelate(lower, n, result.y);
  for (Index j = 0; j < result.columns.cols(); ++j) decorrelate(lower, n, result.columns.col(j));
  result.y += result.columns * back;
  return result;
}

std::vector<FindingOutput> outputs_moved(const Problem& problem, const Eigen::VectorXd& beyond,
                                         const Eigen::VectorXd& before,
                                         const Eigen::VectorXd& after) {
  const auto n = static_cast<Index>(problem.learn.size()),
             m = static_cast<Index>(problem.judge.size());
  std::vector<FindingOutput> moved;
  for (std::size_t o = 0; o < problem.outputs.size(); ++o) {
    const auto first = static_cast<Index>(o);
    FindingOutput one{.output = problem.outputs[o].channel.symbol, .unit = problem.outputs[o].unit};
    one.amplitude = std::sqrt(beyond.segment(first * n, n).squaredNorm() / static_cast<double>(n));
    one.shown = true;  // one number moves all outputs
    if (m >= 4)
      one.judge(figures_of(before.segment(first * m, m)), figures_of(after.segment(first * m, m)));
    moved.push_back(std::move(one));
  }
  return moved;
}

}  // namespace driftwise::diagnosis
