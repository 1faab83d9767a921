#include "server/identification/pose_rows.h"

#include <cmath>

#include "server/core/data/row_marks.h"
#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::identification {
namespace {

using Eigen::Index;

Result<const std::vector<double>*> values_of(const Dataset& dataset, const Channel& channel) {
  const DatasetColumn* column = dataset.find(channel.symbol);
  if (column == nullptr) {
    std::string known;
    for (const auto& one : dataset.columns)
      known += (known.empty() ? "" : " ") + one.channel.name();
    return fail(
        ErrorCode::invalid_argument, reasons::kUnknownChannel,
        "the robot's kinematics needs channel " + channel.name() + ", the data have: " + known);
  }
  if (column->channel.unit != channel.unit)
    return fail(ErrorCode::invalid_argument, reasons::kWrongUnit,
                "the robot's kinematics needs " + channel.name() + ", the data have " +
                    column->channel.name());
  return &column->values;
}

}  // namespace

Result<MechanismData> mechanism_data(const Dataset& dataset,
                                     const kinematics::Mechanism& mechanism) {
  const auto rows = static_cast<Index>(dataset.rows);
  MechanismData data;
  data.inputs.resize(static_cast<Index>(mechanism.inputs().size()), rows);
  data.outputs.resize(rows, static_cast<Index>(mechanism.outputs().size()));
  for (Index i = 0; i < data.inputs.rows(); ++i) {
    DRIFTWISE_TRY(const auto values,
                  values_of(dataset, mechanism.inputs()[static_cast<std::size_t>(i)]));
    data.inputs.row(i) = Eigen::Map<const Eigen::RowVectorXd>(values->data(), rows);
  }
  for (Index o = 0; o < data.outputs.cols(); ++o) {
    DRIFTWISE_TRY(const auto values,
                  values_of(dataset, mechanism.outputs()[static_cast<std::size_t>(o)]));
    data.outputs.col(o) = Eigen::Map<const Eigen::VectorXd>(values->data(), rows);
  }
  return data;
}

Eigen::MatrixXd predict_rows(const kinematics::Mechanism& mechanism, const Eigen::MatrixXd& inputs,
                             const Eigen::VectorXd& values) {
  Eigen::MatrixXd predicted(inputs.cols(), static_cast<Index>(mechanism.outputs().size()));
  for (Index row = 0; row < inputs.cols(); ++row)
    predicted.row(row) =
        mechanism.predict({inputs.col(row).data(), static_cast<std::size_t>(inputs.rows())}, values)
            .value.transpose();
  return predicted;
}

std::vector<std::size_t> complete_rows(const Dataset& dataset, PointSet set,
                                       const std::vector<const Eigen::MatrixXd*>& by_row) {
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < dataset.rows; ++row) {
    if (dataset.set_of(row) != set || dataset.is_excluded(row)) continue;
    bool complete = true;
    for (const auto* matrix : by_row)
      complete = complete && matrix->row(static_cast<Index>(row)).allFinite();
    if (complete) rows.push_back(row);
  }
  return rows;
}

Dataset without_incomplete_rows(Dataset dataset, const std::vector<std::string>& symbols) {
  if (dataset.excluded.empty()) dataset.excluded.assign(dataset.rows, 0);
  for (const auto& symbol : symbols) {
    const DatasetColumn* column = dataset.find(symbol);
    if (column == nullptr) continue;
    for (std::size_t row = 0; row < dataset.rows; ++row)
      if (std::isnan(column->values[row]) && !dataset.is_excluded(row))
        dataset.excluded[row] = kExcludedRow;
  }
  return dataset;
}

}  // namespace driftwise::identification
