#include "server/diagnosis/prepared.h"

#include <algorithm>
#include <cmath>

#include "server/calibration/predict.h"
#include "server/diagnosis/smoothing.h"

namespace driftwise::diagnosis {
namespace {

bool is_wave_in_length(const effects::Term& term) {
  return std::ranges::any_of(term.factors, [](const effects::Factor& factor) {
    const auto* call = std::get_if<effects::Call>(&factor);
    return call != nullptr && (call->effect == "sin" || call->effect == "cos");
  });
}

constexpr double kGap = 7e-4, kWidest = 2e-3;  // of the channel's range
constexpr std::size_t kFewestVisits = 3;

// Values that come in tight groups, each group at its mean; the others as they are.
std::vector<double> by_places(const std::vector<double>& values) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (std::isfinite(values[i])) order.push_back(i);
  std::vector<double> result = values;
  if (order.empty()) return result;
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return values[i]; });
  const double range = values[order.back()] - values[order.front()];
  for (std::size_t begin = 0; begin < order.size();) {
    std::size_t end = begin + 1;
    double sum = values[order[begin]];
    for (; end < order.size() && values[order[end]] - values[order[end - 1]] < kGap * range; ++end)
      sum += values[order[end]];
    if (end - begin >= kFewestVisits &&
        values[order[end - 1]] - values[order[begin]] < kWidest * range)
      for (std::size_t k = begin; k < end; ++k)
        result[order[k]] = sum / static_cast<double>(end - begin);
    begin = end;
  }
  return result;
}

}  // namespace

Prepared Prepared::of(const Dataset& dataset) {
  Prepared prepared;
  prepared.data_ = dataset;
  std::vector<double> clock = dataset.time_s;
  if (clock.empty())
    for (std::size_t i = 0; i < dataset.rows; ++i) clock.push_back(static_cast<double>(i));
  for (auto& column : prepared.data_.columns)
    if (is_structure_temperature(column.channel)) column.values = smoothed(clock, column.values);
  prepared.clocked_ = prepared.data_;
  prepared.clocked_.time_s = clock;
  prepared.at_places_ = prepared.clocked_;
  for (auto& column : prepared.at_places_.columns)
    if (column.channel.unit == "mm" &&
        (is_pose_symbol(column.channel.symbol) || is_motor_symbol(column.channel.symbol)))
      column.values = by_places(column.values);
  return prepared;
}

Result<Eigen::MatrixXd> Prepared::columns(const std::vector<effects::Term>& terms) const {
  if (std::ranges::none_of(terms, is_wave_in_length))
    return calibration::raw_columns(clocked_, terms);
  return calibration::raw_columns(at_places_, terms);
}

}  // namespace driftwise::diagnosis
