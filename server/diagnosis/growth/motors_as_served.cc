#include "server/diagnosis/growth/motors_as_served.h"

#include <map>

#include "server/diagnosis/rows/held_out_gain.h"

namespace driftwise::diagnosis {
namespace {

using Index = Eigen::Index;

LeftOfCoordinate judged(const Problem& problem) {
  return [&problem](const ProblemOutput& coordinate, const SoftBase& simulation) {
    return judged_residuals(problem, coordinate, simulation);
  };
}

}  // namespace

Eigen::MatrixXd motors_as_served(const CoordinateFrame& frame, const Problem& problem,
                                 const Extension& extension, const std::vector<std::size_t>& rows,
                                 const LeftOfCoordinate& left, std::optional<std::size_t> without) {
  const auto size = static_cast<Index>(frame.motors.size());
  Eigen::MatrixXd result(static_cast<Index>(rows.size()), size);
  // Motors of which the same is said share their fits.
  std::map<std::vector<bool>, Eigen::MatrixXd> turned;
  for (Index m = 0; m < size; ++m) {
    const std::string& motor = frame.motors[static_cast<std::size_t>(m)].channel.symbol;
    std::vector<bool> said;
    for (std::size_t i = 0; i < extension.named().size(); ++i)
      said.push_back(i != without && extension.is_said_of(i, motor));
    auto& of_all = turned[said];
    if (of_all.size() == 0) {
      Eigen::MatrixXd coordinates(result.rows(), size);
      for (Index c = 0; c < size; ++c) {
        const auto at = static_cast<std::size_t>(c);
        coordinates.col(c) = left(problem.outputs[at], extension.described(at, without, motor));
      }
      of_all = frame.of_motors(coordinates, rows);
    }
    result.col(m) = of_all.col(m);
  }
  return result;
}

Eigen::MatrixXd judged_motors_as_served(const CoordinateFrame& frame, const Problem& problem,
                                        const Extension& extension,
                                        std::optional<std::size_t> without) {
  return motors_as_served(frame, problem, extension, problem.judge, judged(problem), without);
}

Eigen::MatrixXd judged_motors_by_baseline(const CoordinateFrame& frame, const Problem& problem) {
  Eigen::MatrixXd coordinates(static_cast<Index>(problem.judge.size()),
                              static_cast<Index>(problem.outputs.size()));
  for (Index c = 0; c < coordinates.cols(); ++c)
    coordinates.col(c) = judged_residuals(problem, problem.outputs[static_cast<std::size_t>(c)],
                                          SoftBase(problem.base_columns));
  return frame.of_motors(coordinates, problem.judge);
}

}  // namespace driftwise::diagnosis
