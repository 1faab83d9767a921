#include "server/diagnosis/search/directions.h"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <string>

namespace driftwise::diagnosis {
namespace {

using Index = Eigen::Index;

constexpr double kMovedAlone = 1e-6;  // of a column's length beyond the others

bool is_output(const Problem& problem, const std::string& symbol) {
  return std::ranges::any_of(problem.outputs,
                             [&](const auto& one) { return one.channel.symbol == symbol; });
}

void add_motors_of(const CoordinateFrame& frame, const Problem& problem,
                   std::vector<Direction>& result) {
  const auto size = static_cast<Index>(frame.motors.size());
  Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(size, size);
  for (const std::size_t row : problem.learn)
    mean += frame.turn[row] / static_cast<double>(problem.learn.size());
  const Eigen::MatrixXd of_motors = mean.inverse();
  if (!of_motors.allFinite()) return;
  for (Index m = 0; m < size; ++m) {
    const auto& motor = frame.motors[static_cast<std::size_t>(m)];
    result.push_back({motor.channel.symbol, motor.unit, of_motors.col(m)});
  }
}

// Of coordinates where the outputs are motors, of motors where they are coordinates.
void add_by_slopes(const Problem& problem, std::vector<Direction>& result) {
  const bool of_motors = is_motor_symbol(problem.outputs.front().channel.symbol);
  const auto rows = static_cast<Index>(problem.learn.size());
  std::vector<Direction> found;
  std::vector<Eigen::VectorXd> columns = {Eigen::VectorXd::Ones(rows)};
  for (const auto& column : problem.data().columns) {
    const Channel& channel = column.channel;
    const bool asked =
        of_motors ? is_coordinate(problem, channel) : is_motor_symbol(channel.symbol);
    if (!asked || is_output(problem, channel.symbol)) continue;
    const auto unit = summary_unit(channel.unit);
    Eigen::VectorXd values(rows);
    for (Index i = 0; i < rows; ++i)
      values[i] = unit.factor * column.values[problem.learn[static_cast<std::size_t>(i)]];
    values.array() -= values.mean();
    if (!values.allFinite() || !(values.norm() > 0)) continue;
    columns.push_back(std::move(values));
    found.push_back({channel.symbol, unit.unit, {}});
  }
  if (found.empty() || rows <= static_cast<Index>(columns.size())) return;
  Eigen::MatrixXd z(rows, static_cast<Index>(columns.size()));
  for (std::size_t k = 0; k < columns.size(); ++k) z.col(static_cast<Index>(k)) = columns[k];
  const Eigen::RowVectorXd inverse = z.colwise().norm().cwiseInverse();
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(z * inverse.asDiagonal());
  qr.setThreshold(kMovedAlone);
  if (qr.rank() < z.cols()) return;
  Eigen::MatrixXd measured(rows, static_cast<Index>(problem.outputs.size()));
  for (std::size_t o = 0; o < problem.outputs.size(); ++o)
    for (Index i = 0; i < rows; ++i)
      measured(i, static_cast<Index>(o)) =
          problem.outputs[o]
              .measured[static_cast<Index>(problem.learn[static_cast<std::size_t>(i)])];
  if (!measured.allFinite()) return;
  const Eigen::MatrixXd slopes = inverse.asDiagonal() * qr.solve(measured);
  for (std::size_t k = 0; k < found.size(); ++k) {
    found[k].per_unit = slopes.row(static_cast<Index>(k) + 1).transpose();
    if (found[k].per_unit.norm() > 0) result.push_back(std::move(found[k]));
  }
}

}  // namespace

std::vector<Direction> directions_of(const Problem& problem,
                                     const std::optional<CoordinateFrame>& frame) {
  std::vector<Direction> result;
  const auto size = static_cast<Index>(problem.outputs.size());
  if (size < 2) return result;
  for (Index o = 0; o < size; ++o) {
    const auto& output = problem.outputs[static_cast<std::size_t>(o)];
    const auto& symbol = output.channel.symbol;
    if (is_motor_symbol(symbol) || is_pose_symbol(symbol))
      result.push_back({symbol, output.unit, Eigen::VectorXd::Unit(size, o)});
  }
  if (frame)
    add_motors_of(*frame, problem, result);
  else
    add_by_slopes(problem, result);
  return result;
}

}  // namespace driftwise::diagnosis
