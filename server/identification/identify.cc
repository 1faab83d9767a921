#include "server/identification/identify.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <set>

#include "server/calibration/design/design.h"
#include "server/calibration/design/predict.h"
#include "server/calibration/linear/undetermined.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/effects/term_order.h"
#include "server/identification/frame_start.h"
#include "server/identification/identifiability.h"
#include "server/identification/least_squares.h"
#include "server/identification/pose_rows.h"
#include "server/identification/serial_covariance.h"
#include "server/kinematics/frame.h"

namespace driftwise::identification {
namespace {

using Eigen::Index;

constexpr double kWeak = 10;  // natural units: a millimetre, or the angle that moves the end by one

// datum(k) of every further datum among the calibration rows, then the offered terms that do not
// read what the mechanism itself explains.
std::vector<effects::Term> linear_terms(const Dataset& dataset, const IdentifyOptions& options) {
  std::vector<effects::Term> terms;
  const auto ordinals = calibration::datum_ordinals(dataset);
  std::set<int> datums;
  for (std::size_t row = 0; row < dataset.rows; ++row)
    if (dataset.set_of(row) == PointSet::calibration && !dataset.is_excluded(row))
      datums.insert(static_cast<int>(ordinals[row]));
  for (const int datum : datums)
    if (datum != *datums.begin()) terms.push_back(effects::datum_term(datum));
  for (const auto& term : options.terms) {
    const auto symbols = effects::symbols_of(term);
    const bool geometric = std::ranges::any_of(symbols, [&](const std::string& symbol) {
      return std::ranges::any_of(options.mechanism->inputs(),
                                 [&](const Channel& input) { return input.symbol == symbol; });
    });
    if (!geometric && !term.is_constant()) terms.push_back(term);
  }
  return terms;
}

// Takes out the terms that the calibration rows do not determine, and gives them back.
std::vector<effects::Term> take_undetermined(const Dataset& dataset, const Eigen::MatrixXd& columns,
                                             std::vector<effects::Term>& terms) {
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < dataset.rows; ++row)
    if (dataset.set_of(row) == PointSet::calibration && !dataset.is_excluded(row) &&
        columns.row(static_cast<Index>(row)).allFinite())
      rows.push_back(row);
  Eigen::MatrixXd learned(static_cast<Index>(rows.size()), columns.cols() + 1);
  learned.col(0).setOnes();
  for (std::size_t i = 0; i < rows.size(); ++i)
    learned.row(static_cast<Index>(i)).tail(columns.cols()) =
        columns.row(static_cast<Index>(rows[i]));
  const auto gone = calibration::undetermined(learned, 1);
  std::vector<effects::Term> kept, out;
  for (std::size_t k = 0; k < terms.size(); ++k)
    (gone[k + 1] != 0 ? out : kept).push_back(terms[k]);
  terms = std::move(kept);
  return out;
}

// What the least squares works on. Unknowns: free parameters in natural units, then per output the
// coefficients of the centred and scaled columns.
struct Work {
  const kinematics::Mechanism& mechanism;
  Eigen::MatrixXd inputs;         // inputs x rows
  Eigen::MatrixXd outputs;        // rows x outputs
  Eigen::MatrixXd columns;        // rows x terms, centred, scaled to one half range
  Eigen::VectorXd means, halves;  // of the raw columns
  Eigen::VectorXd start;          // of all parameters
  std::vector<Index> free;        // of the parameters

  Index rows() const { return outputs.rows(); }
  Index unknowns() const {
    return static_cast<Index>(free.size()) + columns.cols() * outputs.cols();
  }
  double natural(Index k) const {
    return mechanism.parameters()[static_cast<std::size_t>(free[static_cast<std::size_t>(k)])]
        .natural;
  }

  Eigen::VectorXd parameters(const Eigen::VectorXd& unknown) const {
    Eigen::VectorXd values = start;
    for (Index k = 0; k < static_cast<Index>(free.size()); ++k)
      values[free[static_cast<std::size_t>(k)]] += unknown[k] * natural(k);
    return values;
  }
  Eigen::MatrixXd linear(const Eigen::VectorXd& unknown) const {  // terms x outputs
    return Eigen::Map<const Eigen::MatrixXd>(unknown.data() + static_cast<Index>(free.size()),
                                             columns.cols(), outputs.cols());
  }
  // Predicted minus measured, output by output.
  Eigen::VectorXd residuals(const Eigen::VectorXd& unknown) const {
    Eigen::MatrixXd left = predict_rows(mechanism, inputs, parameters(unknown)) - outputs;
    if (columns.cols() > 0) left += columns * linear(unknown);
    return left.reshaped();
  }
  // Of the mechanism's outputs with respect to all parameters, per natural unit.
  Eigen::MatrixXd mechanism_jacobian(const Eigen::VectorXd& values) const {
    const auto& all = mechanism.parameters();
    Eigen::MatrixXd jacobian(outputs.size(), static_cast<Index>(all.size()));
    for (Index row = 0; row < rows(); ++row) {
      const auto at =
          mechanism.predict({inputs.col(row).data(), static_cast<std::size_t>(inputs.rows())},
                            values, kinematics::Derivatives::yes);
      for (Index o = 0; o < outputs.cols(); ++o)
        jacobian.row(o * rows() + row) = at.jacobian.row(o);
    }
    for (Index k = 0; k < jacobian.cols(); ++k)
      jacobian.col(k) *= all[static_cast<std::size_t>(k)].natural;
    return jacobian;
  }
  Eigen::MatrixXd jacobian(const Eigen::VectorXd& unknown) const {
    const Eigen::MatrixXd whole = mechanism_jacobian(parameters(unknown));
    Eigen::MatrixXd result = Eigen::MatrixXd::Zero(outputs.size(), unknowns());
    for (std::size_t k = 0; k < free.size(); ++k)
      result.col(static_cast<Index>(k)) = whole.col(free[k]);
    for (Index o = 0; o < outputs.cols(); ++o)
      result.block(o * rows(), static_cast<Index>(free.size()) + o * columns.cols(), rows(),
                   columns.cols()) = columns;
    return result;
  }
};

Eigen::MatrixXd rows_of(const Eigen::MatrixXd& all, const std::vector<std::size_t>& rows) {
  Eigen::MatrixXd some(static_cast<Index>(rows.size()), all.cols());
  for (std::size_t i = 0; i < rows.size(); ++i)
    some.row(static_cast<Index>(i)) = all.row(static_cast<Index>(rows[i]));
  return some;
}

// The geometry stands where every column is 0: at the mean of what was offered, and in the first
// datum, which is the one that targets and robot files are stated in. So datum(k) is not centred.
void centre_columns(const std::vector<effects::Term>& terms, Work& work) {
  work.means = term_means(terms, work.columns);
  work.halves = Eigen::VectorXd::Ones(work.columns.cols());
  for (Index j = 0; j < work.columns.cols(); ++j) {
    auto column = work.columns.col(j);
    const double half = 0.5 * (column.maxCoeff() - column.minCoeff());
    if (half > 0) work.halves[j] = half;
    column = (column.array() - work.means[j]) / work.halves[j];
  }
}

// Nominal values; an arm's frame where its nominal points come closest to the measured ones.
Result<Eigen::VectorXd> start_values(const Work& work) {
  Eigen::VectorXd values = kinematics::nominal_values(work.mechanism.parameters());
  if (!work.mechanism.predicts_pose()) return values;
  Eigen::VectorXd at_zero = values;
  at_zero.head<kinematics::kFrameParameters>().setZero();
  const Eigen::MatrixXd points = predict_rows(work.mechanism, work.inputs, at_zero);
  DRIFTWISE_TRY(const auto frame, frame_start(points.transpose(), work.outputs.transpose(),
                                              work.mechanism.parameters()));
  values.head<kinematics::kFrameParameters>() = frame;
  return values;
}

// Asked of the drawing, not of the solution: what a regular drawing hides (an angle, where the tool
// stands exactly on the last axis) a real robot shows so faintly that least squares would move it
// by many millimetres for nothing.
Identifiability chosen_parameters(const Work& work, const IdentifyOptions& options) {
  kinematics::Parameters parameters = work.mechanism.parameters();
  if (options.placement_only)
    for (auto& parameter : parameters) parameter.held = parameter.held || !parameter.placement;
  auto result = identifiable(work.mechanism_jacobian(work.start), parameters);
  if (options.placement_only)
    for (std::size_t i = 0; i < parameters.size(); ++i)
      if (!parameters[i].placement) result.notes[i] = "nominal";
  return result;
}

// Holds what such rows determine to no better than kWeak, the weakest first, by the derivatives at
// the start: least squares then has no valley to walk along. Whether any was held.
bool hold_weak(Work& work, Identifiability& chosen) {
  const Eigen::VectorXd still = Eigen::VectorXd::Zero(work.unknowns());
  Eigen::MatrixXd jacobian = work.jacobian(still);
  const Eigen::VectorXd left = work.residuals(still);
  bool any = false;
  while (!work.free.empty() && jacobian.rows() > jacobian.cols()) {
    const Eigen::VectorXd rest = left - jacobian * jacobian.colPivHouseholderQr().solve(left);
    const double variance =
        rest.squaredNorm() / static_cast<double>(jacobian.rows() - jacobian.cols());
    const Eigen::VectorXd errors = (variance * inverse_normal(jacobian).diagonal())
                                       .cwiseSqrt()
                                       .head(static_cast<Index>(work.free.size()));
    Index weakest = 0;
    if (errors.maxCoeff(&weakest) <= kWeak) break;
    const auto held = static_cast<std::size_t>(work.free[static_cast<std::size_t>(weakest)]);
    chosen.free[held] = 0;
    chosen.notes[held] = "held: these rows determine it to no better than a drawing leaves open";
    work.free.erase(work.free.begin() + weakest);
    const Index after = jacobian.cols() - weakest - 1;
    jacobian.middleCols(weakest, after) = jacobian.rightCols(after).eval();
    jacobian.conservativeResize(Eigen::NoChange, jacobian.cols() - 1);
    any = true;
  }
  return any;
}

Identification describe(const Work& work, const Identifiability& chosen,
                        const std::vector<effects::Term>& terms,
                        const LeastSquaresSolution& solution) {
  Identification result;
  const Index outputs = work.outputs.cols(), count = work.columns.cols();
  const auto free = static_cast<Index>(work.free.size());
  result.rows = work.rows();
  result.unknowns = static_cast<int>(work.unknowns());
  result.evaluations = solution.evaluations;
  result.condition = chosen.condition;
  const Eigen::VectorXd left = work.residuals(solution.values);
  result.rss = left.reshaped(work.rows(), outputs).colwise().squaredNorm().transpose();
  const Eigen::MatrixXd whole = serial_covariance(work.jacobian(solution.values), left, outputs);
  const Eigen::VectorXd deviation = whole.diagonal().cwiseSqrt();
  Eigen::VectorXd units(free);
  for (Index k = 0; k < free; ++k) units[k] = work.natural(k);
  result.covariance = units.asDiagonal() * whole.topLeftCorner(free, free) * units.asDiagonal();

  const Eigen::VectorXd values = work.parameters(solution.values);
  for (std::size_t i = 0; i < work.mechanism.parameters().size(); ++i) {
    const auto& parameter = work.mechanism.parameters()[i];
    result.parameters.push_back(
        {parameter, values[static_cast<Index>(i)], 0, chosen.free[i] != 0, chosen.notes[i]});
  }
  for (Index k = 0; k < free; ++k) {
    auto& one = result.parameters[static_cast<std::size_t>(work.free[static_cast<std::size_t>(k)])];
    one.standard_error = deviation[k] * work.natural(k);
    if (deviation[k] > kWeak)
      one.note = "weakly determined: its standard error is far beyond what a drawing leaves open";
  }
  if (count == 0) return result;
  const Eigen::MatrixXd scaled = work.linear(solution.values);
  const Eigen::MatrixXd errors =
      Eigen::Map<const Eigen::MatrixXd>(deviation.data() + free, count, outputs);
  result.terms.push_back({});
  result.terms.insert(result.terms.end(), terms.begin(), terms.end());
  result.coefficients.resize(count + 1, outputs);
  result.standard_errors = Eigen::MatrixXd::Zero(count + 1, outputs);
  result.coefficients.bottomRows(count) = work.halves.cwiseInverse().asDiagonal() * scaled;
  result.standard_errors.bottomRows(count) = work.halves.cwiseInverse().asDiagonal() * errors;
  for (Index o = 0; o < outputs; ++o) {
    Eigen::MatrixXd raw = Eigen::MatrixXd::Zero(count + 1, count);  // of the centred coefficients
    raw.bottomRows(count) = work.halves.cwiseInverse().asDiagonal();
    raw.row(0) = -work.means.transpose() * raw.bottomRows(count);
    result.term_covariances.push_back(
        raw * whole.block(free + o * count, free + o * count, count, count) * raw.transpose());
  }
  result.coefficients.row(0) =
      (-work.means.transpose() * result.coefficients.bottomRows(count)).array() + 0.0;  // no -0
  return result;
}

}  // namespace

Eigen::VectorXd term_means(std::span<const effects::Term> terms, const Eigen::MatrixXd& columns) {
  Eigen::VectorXd means = columns.colwise().mean().transpose();
  for (std::size_t k = 0; k < terms.size(); ++k)
    if (effects::datum_of(terms[k])) means[static_cast<Index>(k)] = 0;
  return means;
}

Eigen::VectorXd Identification::values() const {
  Eigen::VectorXd all(static_cast<Index>(parameters.size()));
  for (std::size_t i = 0; i < parameters.size(); ++i)
    all[static_cast<Index>(i)] = parameters[i].value;
  return all;
}

std::vector<char> Identification::free() const {
  std::vector<char> all;
  for (const auto& one : parameters) all.push_back(one.free ? 1 : 0);
  return all;
}

Result<Identification> identify(const Dataset& dataset, const IdentifyOptions& options) {
  DRIFTWISE_TRY(const auto data, mechanism_data(dataset, *options.mechanism));
  auto terms = linear_terms(dataset, options);
  auto columns = calibration::raw_columns(dataset, terms);
  DRIFTWISE_RETURN_IF_ERROR(columns);
  auto undetermined = take_undetermined(dataset, *columns, terms);
  if (!undetermined.empty()) columns = calibration::raw_columns(dataset, terms);
  const Eigen::MatrixXd inputs_by_row = data.inputs.transpose();
  const auto rows =
      complete_rows(dataset, PointSet::calibration, {&inputs_by_row, &data.outputs, &*columns});
  Work work{*options.mechanism,
            rows_of(inputs_by_row, rows).transpose(),
            rows_of(data.outputs, rows),
            rows_of(*columns, rows),
            {},
            {},
            {},
            {}};
  if (rows.size() < 3)
    return fail(ErrorCode::failed_precondition, reasons::kTooFewRows,
                std::to_string(rows.size()) +
                    " complete calibration rows: measure more before identifying a robot");
  centre_columns(terms, work);
  DRIFTWISE_TRY(auto start, start_values(work));
  work.start = std::move(start);
  if (!predict_rows(work.mechanism, work.inputs, work.start).allFinite())
    return fail(ErrorCode::failed_precondition, reasons::kBadStart,
                "the nominal geometry does not reach every measured row: compare lengths, units "
                "and frames of the robot file with the data");
  Identifiability chosen = chosen_parameters(work, options);
  for (std::size_t i = 0; i < chosen.free.size(); ++i)
    if (chosen.free[i] != 0) work.free.push_back(static_cast<Index>(i));
  const LeastSquaresProblem problem{
      [&work](const Eigen::VectorXd& unknown) { return work.residuals(unknown); },
      [&work](const Eigen::VectorXd& unknown) { return work.jacobian(unknown); }};
  if (work.outputs.size() <= work.unknowns())
    return fail(ErrorCode::failed_precondition, reasons::kTooFewRows,
                std::to_string(work.outputs.size()) + " measured values for " +
                    std::to_string(work.unknowns()) +
                    " unknowns: any numbers of the robot fit them, and nothing says how well; "
                    "measure more poses, or hold parameters");
  auto solution = minimise(problem, Eigen::VectorXd::Zero(work.unknowns()));
  if (!solution && solution.error().reason == reasons::kNoConvergence && hold_weak(work, chosen))
    solution = minimise(problem, Eigen::VectorXd::Zero(work.unknowns()));
  DRIFTWISE_RETURN_IF_ERROR(solution);
  Identification result = describe(work, chosen, terms, *solution);
  result.mechanism = options.mechanism;
  result.undetermined = std::move(undetermined);
  return result;
}

Result<Eigen::MatrixXd> predict(const Dataset& dataset, const Identification& identification) {
  DRIFTWISE_TRY(const auto data, mechanism_data(dataset, *identification.mechanism));
  Eigen::MatrixXd predicted =
      predict_rows(*identification.mechanism, data.inputs, identification.values());
  if (identification.terms.empty()) return predicted;
  DRIFTWISE_TRY(const auto columns, calibration::raw_columns(dataset, identification.terms));
  predicted += columns * identification.coefficients;
  return predicted;
}

}  // namespace driftwise::identification
