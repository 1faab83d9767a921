#include "server/identification/least_squares.h"

#include <cminpack.h>

#include <cmath>
#include <limits>
#include <vector>

#include "server/core/reasons.h"
#include "server/core/text/quantity_text.h"

namespace driftwise::identification {
namespace {

constexpr double kTolerance = 1e-13;    // relative, of the sum of squares and of the values
constexpr double kInitialStep = 100.0;  // MINPACK's recommendation

int evaluate_for_cminpack(void* problem, int rows, int columns, const double* values,
                          double* residuals, double* jacobian, int leading, int which) {
  const auto& asked = *static_cast<const LeastSquaresProblem*>(problem);
  const Eigen::VectorXd at = Eigen::Map<const Eigen::VectorXd>(values, columns);
  if (which == 1)
    Eigen::Map<Eigen::VectorXd>(residuals, rows) = asked.residuals(at);
  else
    Eigen::Map<Eigen::MatrixXd, 0, Eigen::OuterStride<>>(
        jacobian, rows, columns, Eigen::OuterStride<>(leading)) = asked.jacobian(at);
  return 0;
}

}  // namespace

Result<LeastSquaresSolution> minimise(const LeastSquaresProblem& problem,
                                      const Eigen::VectorXd& start, int most_evaluations) {
  Eigen::VectorXd residuals = problem.residuals(start);
  if (!residuals.allFinite())
    return fail(ErrorCode::failed_precondition, reasons::kBadStart,
                "the nominal geometry does not reach every measured row: compare lengths, units "
                "and frames of the robot file with the data");
  LeastSquaresSolution solution{start, residuals.squaredNorm(), 1};
  if (start.size() == 0) return solution;
  if (residuals.size() < start.size())
    return fail(ErrorCode::failed_precondition, reasons::kTooFewRows,
                std::to_string(residuals.size()) + " measured values for " +
                    std::to_string(start.size()) + " unknowns: measure more, or hold parameters");
  const auto rows = static_cast<int>(residuals.size()), columns = static_cast<int>(start.size());
  Eigen::MatrixXd jacobian(rows, columns);
  std::vector<int> pivots(start.size());
  Eigen::VectorXd scale(columns), projected(columns), work1(columns), work2(columns),
      work3(columns), work4(rows);
  int evaluations = 0, derivatives = 0;
  const int info = lmder(evaluate_for_cminpack, const_cast<LeastSquaresProblem*>(&problem), rows,
                         columns, solution.values.data(), residuals.data(), jacobian.data(), rows,
                         kTolerance, kTolerance, 0.0, most_evaluations, scale.data(), 1,
                         kInitialStep, 0, &evaluations, &derivatives, pivots.data(),
                         projected.data(), work1.data(), work2.data(), work3.data(), work4.data());
  solution.sum_of_squares = residuals.squaredNorm();
  solution.evaluations = evaluations;
  // 1 to 4: a tolerance is met; 6 to 8: it is met as far as double precision goes.
  if (info >= 1 && info != 5 && solution.values.allFinite()) return solution;
  return fail(ErrorCode::failed_precondition, reasons::kNoConvergence,
              "no minimum found in " + std::to_string(evaluations) +
                  " evaluations (root mean square of what is left " +
                  digits_text(std::sqrt(solution.sum_of_squares / rows)) +
                  "): hold parameters that the data hardly determine, or start nearer");
}

}  // namespace driftwise::identification
