#include "server/diagnosis/search/coordinate_frame.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "server/diagnosis/noise/robust.h"
#include "server/diagnosis/rows/hidden_readings.h"
#include "server/effects/term_order.h"

namespace driftwise::diagnosis {
namespace {

using Index = Eigen::Index;

constexpr int kRounds = 6;
constexpr Index kMostRows = 20000;     // slopes of all rows are held in memory
constexpr double kStep = 1e-3;         // of a coordinate's range: slopes are taken over it
constexpr double kFarOff = 8;          // robust standard deviations, of a row that has no weight
constexpr double kIndependent = 1e-9;  // of a column's length beyond the others

std::vector<const DatasetColumn*> coordinates_in_base(const Problem& problem) {
  std::vector<const DatasetColumn*> result;
  for (const auto& column : problem.data().columns) {
    if (!is_coordinate(problem, column.channel)) continue;
    if (std::ranges::any_of(problem.base, [&](const effects::Term& term) {
          const auto read = effects::symbols_of(term);
          return std::ranges::find(read, column.channel.symbol) != read.end();
        }))
      result.push_back(&column);
  }
  return result;
}

// Slopes of the baseline's columns along each coordinate, at the pose that `problem` has.
std::optional<std::vector<Eigen::MatrixXd>> slopes_of_columns(
    const Problem& problem, const std::vector<const DatasetColumn*>& coordinates) {
  const auto here = problem.prepared.columns(problem.base);
  if (!here) return std::nullopt;
  std::vector<Eigen::MatrixXd> result;
  for (const auto* coordinate : coordinates) {
    const auto& symbol = coordinate->channel.symbol;
    const auto values = problem.prepared.conditions().values_of(symbol);
    std::vector<double> moved(values.begin(), values.end());
    double low = INFINITY, high = -INFINITY;
    for (const double one : moved)
      if (std::isfinite(one)) low = std::min(low, one), high = std::max(high, one);
    const double step = kStep * (high - low);
    if (!(step > 0)) return std::nullopt;
    for (double& one : moved) one += step;
    Prepared beside = problem.prepared;
    beside.set_coordinate(symbol, moved);
    const auto there = beside.columns(problem.base);
    if (!there) return std::nullopt;
    result.emplace_back((*there - *here) / step);
  }
  return result;
}

double two_ln_of(const Eigen::MatrixXd& left) {
  return -static_cast<double>(left.rows()) *
         (left.colwise().squaredNorm().array() / static_cast<double>(left.rows())).log().sum();
}

// The baseline's columns, orthonormal over the rows that learn, their slopes along each coordinate,
// and the motors.
struct LaidColumns {
  Eigen::MatrixXd columns, motors;
  std::vector<Eigen::MatrixXd> slopes;
};

std::optional<LaidColumns> laid_columns(const Problem& problem,
                                        const std::vector<const DatasetColumn*>& coordinates) {
  auto slopes = slopes_of_columns(problem, coordinates);
  if (!slopes) return std::nullopt;
  Eigen::MatrixXd learned = rows_of(problem.base_columns, problem.learn);
  const Eigen::RowVectorXd scale = learned.colwise().norm().cwiseMax(1e-300).cwiseInverse();
  learned = learned * scale.asDiagonal();
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(learned);
  const Index count = learned.cols();
  if (qr.matrixQR().diagonal().cwiseAbs().minCoeff() < kIndependent) return std::nullopt;
  const Eigen::MatrixXd r = qr.matrixQR().topRows(count);
  const Eigen::MatrixXd to = scale.asDiagonal() * r.triangularView<Eigen::Upper>().solve(
                                                      Eigen::MatrixXd::Identity(count, count));
  LaidColumns result{problem.base_columns * to, {}, std::move(*slopes)};
  for (auto& one : result.slopes) one = one * to;
  result.motors.resize(problem.base_columns.rows(), static_cast<Index>(problem.outputs.size()));
  for (std::size_t o = 0; o < problem.outputs.size(); ++o)
    result.motors.col(static_cast<Index>(o)) = problem.outputs[o].measured;
  return result;
}

// The baseline fitted to all coordinates together.
struct FittedTogether {
  Eigen::MatrixXd coefficients, left;   // columns x motors; rows x coordinates
  std::vector<Eigen::MatrixXd> slopes;  // of every row, motors x coordinates
  double two_ln = 0;                    // likelihood, as densities of the motors
};

// left and slopes by the coefficients.
void turn_rows(const LaidColumns& laid, const std::vector<std::size_t>& rows,
               FittedTogether& fitted) {
  const Eigen::MatrixXd off = laid.motors - laid.columns * fitted.coefficients;
  const Index size = off.cols();
  fitted.left.resize(off.rows(), size);
  fitted.slopes.assign(static_cast<std::size_t>(off.rows()), Eigen::MatrixXd(size, size));
  for (Index i = 0; i < off.rows(); ++i) {
    auto& slope = fitted.slopes[static_cast<std::size_t>(i)];
    for (Index k = 0; k < size; ++k)
      slope.col(k) =
          (laid.slopes[static_cast<std::size_t>(k)].row(i) * fitted.coefficients).transpose();
    fitted.left.row(i) = slope.partialPivLu().solve(off.row(i).transpose()).transpose();
  }
  fitted.two_ln = two_ln_of(rows_of(fitted.left, rows));
  for (const std::size_t row : rows)
    fitted.two_ln -= 2 * std::log(std::abs(fitted.slopes[row].determinant()));
}

// One step of least squares, each coordinate by its noise. Rows far off have no weight.
bool improve_together(const LaidColumns& laid, const std::vector<std::size_t>& rows,
                      FittedTogether& fitted) {
  const Eigen::MatrixXd here = rows_of(fitted.left, rows), z = rows_of(laid.columns, rows);
  const Eigen::MatrixXd off = rows_of(laid.motors, rows) - z * fitted.coefficients;
  const Index size = here.cols(), count = z.cols(), n = z.rows();
  if (!here.allFinite()) return false;
  Eigen::VectorXd sd(size);
  Eigen::ArrayXd weight = Eigen::ArrayXd::Ones(n);
  for (Index c = 0; c < size; ++c) {
    sd[c] = robust_sd({here.col(c).begin(), here.col(c).end()});
    if (!(sd[c] > 0)) return false;
    weight *= (here.col(c).array().abs() <= kFarOff * sd[c]).cast<double>();
  }
  std::vector<Eigen::MatrixXd> precision;
  for (const std::size_t row : rows) {
    const Eigen::MatrixXd scaled =
        sd.cwiseInverse().asDiagonal() * Eigen::MatrixXd(fitted.slopes[row].inverse());
    precision.emplace_back(scaled.transpose() * scaled);
  }
  Eigen::MatrixXd a(count * size, count * size);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(count * size);
  for (Index p = 0; p < size; ++p)
    for (Index q = 0; q <= p; ++q) {
      Eigen::ArrayXd w(n);
      for (Index i = 0; i < n; ++i) w[i] = weight[i] * precision[static_cast<std::size_t>(i)](p, q);
      const Eigen::MatrixXd weighted = z.array().colwise() * w;
      const Eigen::MatrixXd block = weighted.transpose() * z;
      a.block(p * count, q * count, count, count) = block;
      a.block(q * count, p * count, count, count) = block.transpose();
      b.segment(p * count, count) += weighted.transpose() * off.col(q);
      if (q < p) b.segment(q * count, count) += weighted.transpose() * off.col(p);
    }
  const Eigen::VectorXd lengths = a.diagonal().cwiseSqrt().cwiseMax(1e-300).cwiseInverse();
  const Eigen::LLT<Eigen::MatrixXd> cholesky(lengths.asDiagonal() * a * lengths.asDiagonal());
  if (cholesky.info() != Eigen::Success) return false;
  const Eigen::VectorXd change = lengths.cwiseProduct(cholesky.solve(lengths.cwiseProduct(b)));
  fitted.coefficients += change.reshaped(count, size);
  return true;
}

std::optional<FittedTogether> fitted_to(const LaidColumns& laid,
                                        const std::vector<std::size_t>& rows,
                                        const Eigen::MatrixXd& first) {
  FittedTogether fitted{first, {}, {}, 0};
  turn_rows(laid, rows, fitted);
  for (int round = 0; round < kRounds; ++round) {
    if (!improve_together(laid, rows, fitted)) return std::nullopt;
    turn_rows(laid, rows, fitted);
  }
  if (!std::isfinite(fitted.two_ln)) return std::nullopt;
  return fitted;
}

}  // namespace

Eigen::MatrixXd CoordinateFrame::of_motors(const Eigen::MatrixXd& of_coordinates,
                                           const std::vector<std::size_t>& rows) const {
  Eigen::MatrixXd result(of_coordinates.rows(), static_cast<Index>(motors.size()));
  for (Index i = 0; i < result.rows(); ++i)
    result.row(i) = of_coordinates.row(i) * turn[rows[static_cast<std::size_t>(i)]].transpose();
  return result;
}

Problem with_all_rows_fitted(Problem problem, const std::optional<CoordinateFrame>& frame) {
  if (!frame) return problem;
  for (std::size_t c = 0; c < problem.outputs.size(); ++c) {
    auto& output = problem.outputs[c];
    output.measured = frame->by_all_rows.col(static_cast<Index>(c));
    if (output.freed_of.size() > 0) output.measured -= output.freed_of;
  }
  return problem;
}

std::optional<CoordinateFrame> in_coordinates(const Problem& problem) {
  const auto coordinates = coordinates_in_base(problem);
  const auto size = static_cast<Index>(coordinates.size());
  const bool all_motors = std::ranges::all_of(
      problem.outputs, [](const auto& output) { return is_motor_symbol(output.channel.symbol); });
  if (size < 2 || !all_motors || coordinates.size() != problem.outputs.size() ||
      problem.base_columns.rows() > kMostRows)
    return std::nullopt;
  const auto laid = laid_columns(problem, coordinates);
  if (!laid) return std::nullopt;
  const Eigen::MatrixXd z = rows_of(laid->columns, problem.learn),
                        y = rows_of(laid->motors, problem.learn);
  const Eigen::MatrixXd each = z.transpose() * y;
  const auto fitted = fitted_to(*laid, problem.learn, each);
  if (!fitted || !(fitted->two_ln - two_ln_of(y - z * each) > kFramesTold)) return std::nullopt;
  std::vector<std::size_t> all = problem.learn;
  all.insert(all.end(), problem.judge.begin(), problem.judge.end());
  std::ranges::sort(all);
  all.erase(std::ranges::unique(all).begin(), all.end());
  const auto by_all = fitted_to(*laid, all, fitted->coefficients);
  if (!by_all) return std::nullopt;
  CoordinateFrame result{problem, problem.outputs, {}, {}};
  result.problem.given_outputs = problem.output_symbols();
  result.problem.outputs.clear();
  Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(size, size);
  for (const std::size_t row : problem.learn)
    mean += fitted->slopes[row] / static_cast<double>(problem.learn.size());
  const Eigen::MatrixXd turned = laid->columns * fitted->coefficients * mean.inverse().transpose();
  Eigen::VectorXd factors(size);
  for (Index c = 0; c < size; ++c) {
    const Channel& channel = coordinates[static_cast<std::size_t>(c)]->channel;
    const auto unit = summary_unit(channel.unit);
    factors[c] = unit.factor;
    result.problem.outputs.push_back(
        {channel, unit.unit, unit.factor, (turned.col(c) + fitted->left.col(c)) * unit.factor});
  }
  result.by_all_rows = (turned + by_all->left) * factors.asDiagonal();
  for (const auto& one : fitted->slopes)
    result.turn.emplace_back(one * factors.cwiseInverse().asDiagonal());
  auto hidden = hidden_in(result.problem);
  if (!hidden) return std::nullopt;
  result.problem.hidden = std::move(*hidden);
  return result;
}

}  // namespace driftwise::diagnosis
