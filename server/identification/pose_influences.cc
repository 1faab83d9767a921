#include "server/identification/pose_influences.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <map>

#include "server/calibration/design/predict.h"
#include "server/calibration/report/influence.h"
#include "server/core/try.h"
#include "server/effects/term_order.h"
#include "server/identification/pose_rows.h"

namespace driftwise::identification {
namespace {

using Eigen::Index;

constexpr std::size_t kEnoughRows = 2000;
constexpr double kDetermined = 1e-7;  // as identifiability.h has it

std::vector<std::size_t> spread(const std::vector<std::size_t>& rows, std::size_t at_most) {
  if (rows.size() <= at_most) return rows;
  std::vector<std::size_t> some;
  for (std::size_t i = 0; i < at_most; ++i) some.push_back(rows[i * rows.size() / at_most]);
  return some;
}

std::vector<Index> indices(const std::vector<std::size_t>& rows) {
  return {rows.begin(), rows.end()};
}

// Derivatives of the outputs, one below the other, by the free parameters and then by the
// coefficients of each output. Columns have unit length; result = unit column * scale.
struct Derivatives {
  Eigen::MatrixXd columns;
  Eigen::VectorXd scale;
  Eigen::RowVectorXd means;  // term_means() of the terms, the constant left out
  std::vector<Index> free;
};

Derivatives derivatives_of(const Identification& found, const MechanismData& data,
                           const Eigen::MatrixXd& terms, const std::vector<Index>& rows) {
  Derivatives out;
  for (std::size_t i = 0; i < found.parameters.size(); ++i)
    if (found.parameters[i].free) out.free.push_back(static_cast<Index>(i));
  const Index outputs = data.outputs.cols(), count = static_cast<Index>(rows.size()),
              free = static_cast<Index>(out.free.size()),
              linear = std::max<Index>(terms.cols() - 1, 0);
  out.columns = Eigen::MatrixXd::Zero(count * outputs, free + linear * outputs);
  const Eigen::VectorXd values = found.values();
  for (Index i = 0; i < count; ++i) {
    const Index row = rows[static_cast<std::size_t>(i)];
    const auto at = found.mechanism->predict(
        {data.inputs.col(row).data(), static_cast<std::size_t>(data.inputs.rows())}, values,
        kinematics::Derivatives::yes);
    for (Index o = 0; o < outputs; ++o)
      for (Index k = 0; k < free; ++k)
        out.columns(o * count + i, k) = at.jacobian(o, out.free[static_cast<std::size_t>(k)]);
  }
  if (linear > 0) {
    Eigen::MatrixXd centred = terms(rows, Eigen::seq(1, linear));
    out.means = term_means(std::span(found.terms).subspan(1), centred).transpose();
    centred.rowwise() -= out.means;
    for (Index o = 0; o < outputs; ++o)
      out.columns.block(o * count, free + o * linear, count, linear) = centred;
  }
  out.scale = out.columns.colwise().norm().transpose().cwiseMax(1e-300);
  out.columns = (out.columns * out.scale.cwiseInverse().asDiagonal()).eval();
  return out;
}

// Of every output less what was measured of it, by one channel, rows x outputs, per unit of its
// column.
Result<Eigen::MatrixXd> slopes_by(const Dataset& dataset, const Identification& found,
                                  const std::string& symbol, const std::vector<Index>& rows) {
  if (found.mechanism->predicts_pose()) {
    const auto& outputs = found.mechanism->outputs();
    Eigen::MatrixXd slopes =
        Eigen::MatrixXd::Zero(static_cast<Index>(rows.size()), static_cast<Index>(outputs.size()));
    slopes.col(std::ranges::find(outputs, symbol, &Channel::symbol) - outputs.begin())
        .setConstant(-1);
    return slopes;
  }
  Dataset moved = dataset;
  const auto column = std::ranges::find(
      moved.columns, symbol, [](const DatasetColumn& one) { return one.channel.symbol; });
  double low = INFINITY, high = -INFINITY;
  for (const Index row : rows) {
    const double value = column->values[static_cast<std::size_t>(row)];
    low = std::min(low, value), high = std::max(high, value);
  }
  const double step = high > low ? 1e-3 * (high - low) : 1e-3;
  for (double& value : column->values) value += step;
  DRIFTWISE_TRY(const auto above, predict(moved, found));
  for (double& value : column->values) value -= 2 * step;
  DRIFTWISE_TRY(const auto below, predict(moved, found));
  return Eigen::MatrixXd((above - below)(rows, Eigen::all) / (2 * step));
}

std::vector<std::string> channels_in_error(const Dataset& dataset, const Identification& found) {
  std::vector<std::string> symbols;
  if (found.mechanism->predicts_pose()) {
    for (const auto& output : found.mechanism->outputs()) symbols.push_back(output.symbol);
    return symbols;
  }
  for (const auto& input : found.mechanism->inputs()) symbols.push_back(input.symbol);
  const bool by_force = std::ranges::any_of(found.terms, [](const effects::Term& term) {
    return std::ranges::count(effects::symbols_of(term), "force") > 0;
  });
  if (by_force && dataset.find("force") != nullptr) symbols.push_back("force");
  return symbols;
}

// Least squares on the derivatives in these of their rows.
class Solver {
 public:
  explicit Solver(const Derivatives& all, Index outputs) : all_(all), outputs_(outputs) {}

  // errors: rows x outputs, of the rows read.
  Eigen::VectorXd solve(const Eigen::MatrixXd& errors, const std::vector<Index>& read) {
    auto found = by_rows_.find(read);
    if (found == by_rows_.end()) {
      const Index count = all_.columns.rows() / outputs_;
      std::vector<Index> rows;
      for (Index o = 0; o < outputs_; ++o)
        for (const Index row : read) rows.push_back(o * count + row);
      found = by_rows_.try_emplace(read).first;
      found->second.setThreshold(kDetermined);
      found->second.compute(Eigen::MatrixXd(all_.columns(rows, Eigen::all)));
    }
    return all_.scale.cwiseInverse().cwiseProduct(
        found->second.solve(Eigen::VectorXd(errors.reshaped())));
  }

 private:
  const Derivatives& all_;
  Index outputs_;
  std::map<std::vector<Index>, Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>> by_rows_;
};

}  // namespace

Result<std::vector<PoseInfluence>> pose_influences(const Dataset& dataset,
                                                   const Identification& found) {
  std::vector<PoseInfluence> out;
  DRIFTWISE_TRY(const auto data, mechanism_data(dataset, *found.mechanism));
  DRIFTWISE_TRY(const auto terms, calibration::raw_columns(dataset, found.terms));
  const Eigen::MatrixXd inputs = data.inputs.transpose();
  const auto rows = spread(
      complete_rows(dataset, PointSet::calibration, {&inputs, &data.outputs, &terms}), kEnoughRows);
  const auto at = indices(rows);
  const Index outputs = data.outputs.cols(), linear = std::max<Index>(terms.cols() - 1, 0);
  const Derivatives derivatives = derivatives_of(found, data, terms, at);
  const auto free = static_cast<Index>(derivatives.free.size());
  const calibration::Excerpt excerpt(dataset, rows, {}, rows.size());
  Solver solver(derivatives, outputs);
  for (const auto& symbol : channels_in_error(dataset, found)) {
    DRIFTWISE_TRY(const auto slopes, slopes_by(dataset, found, symbol, at));
    for (const auto& [by, shape] : calibration::error_shapes(
             excerpt, {}, symbol, static_cast<std::size_t>(derivatives.columns.cols()))) {
      const auto read = calibration::rows_read(shape);
      const Eigen::VectorXd of_rows = shape(read);
      const Eigen::MatrixXd errors = of_rows.asDiagonal() * slopes(read, Eigen::all);
      const Eigen::VectorXd moved = solver.solve(errors, read);
      PoseInfluence one{dataset.find(symbol)->channel.name(), by,
                        (errors.colwise().squaredNorm() / static_cast<double>(read.size()))
                            .cwiseSqrt()
                            .transpose(),
                        moved.head(free), Eigen::MatrixXd::Zero(terms.cols(), outputs)};
      if (linear > 0) {
        one.coefficients.bottomRows(linear) =
            Eigen::Map<const Eigen::MatrixXd>(moved.data() + free, linear, outputs);
        one.coefficients.row(0) =
            (-derivatives.means * one.coefficients.bottomRows(linear)).array() + 0.0;  // no -0
      }
      out.push_back(std::move(one));
    }
  }
  return out;
}

Result<void> add_pose_influences(const Dataset& dataset, const Identification& found,
                                 calibration::Model& model) {
  DRIFTWISE_TRY(const auto influences, pose_influences(dataset, found));
  for (const auto& [channel, by, rms, parameters, coefficients] : influences) {
    model.geometry->influences.push_back({channel, by, rms.norm(), parameters});
    for (std::size_t o = 0; o < model.outputs.size(); ++o) {
      const auto at = static_cast<Index>(o);
      model.outputs[o].influences.push_back({channel, by, rms[at], coefficients.col(at)});
    }
  }
  return {};
}

}  // namespace driftwise::identification
