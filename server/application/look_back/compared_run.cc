#include "server/application/look_back/compared_run.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <optional>

#include "server/application/motion/datum_opening.h"

namespace driftwise::application {
namespace {

constexpr std::size_t kMostValues = 1500;  // of a series: a plot shows no more

// Keeps every n-th value when there are too many.
void thin(ComparedSeries& series) {
  const std::size_t step = (series.values.size() + kMostValues - 1) / kMostValues;
  if (step < 2) return;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < series.values.size(); i += step, ++kept) {
    series.values[kept] = series.values[i];
    series.hours[kept] = series.hours[i];
  }
  series.values.resize(kept);
  series.hours.resize(kept);
}

// Slope of the least-squares line. None: fewer than 3 values, or all at one time.
std::optional<double> rate_of_line(const ComparedSeries& series) {
  const auto n = static_cast<double>(series.hours.size());
  if (n < 3) return std::nullopt;
  const double middle_h = std::accumulate(series.hours.begin(), series.hours.end(), 0.0) / n;
  double spread = 0, product = 0;
  for (std::size_t i = 0; i < series.hours.size(); ++i) {
    const double hours = series.hours[i] - middle_h;
    spread += hours * hours;
    product += hours * series.values[i];
  }
  return spread > 0 ? std::optional(product / spread) : std::nullopt;
}

void finish(ComparedSeries series, std::vector<ComparedSeries>& into) {
  if (series.values.empty()) return;
  const auto [low, high] = std::minmax_element(series.values.begin(), series.values.end());
  series.range = *high - *low;
  for (const double value : series.values)
    series.mean += value / static_cast<double>(series.values.size());
  series.rate_per_h = rate_of_line(series);
  thin(series);
  into.push_back(std::move(series));
}

// std columns of a run's points carry a unit of their own and no pose symbol.
bool is_pose(const Channel& channel) { return is_pose_symbol(channel.symbol); }

bool is_motor(const Channel& channel) { return is_motor_symbol(without_robot(channel.symbol)); }

// A spread of repeats is no temperature.
bool is_compared_temperature(const Channel& channel) {
  return (channel.unit == "degC" || channel.unit == "K") && !channel.symbol.ends_with("_std");
}

// Way of the one axis from its datum's zero, nm, row by row. With one axis and one length the axis'
// own holding error is no error of the return; with several the geometry decides what it moves.
class WayOfAxis {
 public:
  WayOfAxis(const Dataset& data, std::span<const DatumRecord> datums) : data_(data) {
    int lengths = 0, motors = 0;
    for (const auto& column : data.columns) {
      if (is_pose(column.channel) && is_length(column.channel.unit)) ++lengths;
      if (!is_motor(column.channel)) continue;
      ++motors;
      axis_ = &column;
    }
    if (lengths != 1 || motors != 1 || !is_length(axis_->channel.unit)) axis_ = nullptr;
    if (axis_ != nullptr) nm_per_unit_ = summary_unit(axis_->channel.unit).factor;
    for (const auto& datum : datums)
      if (const double* zero = axis_ ? find_value(datum.values, axis_->channel.name()) : nullptr)
        zero_of_[datum.id.value] = *zero;
  }
  double at(std::size_t row) const {
    if (axis_ == nullptr) return 0;
    const auto zero = data_.datum.empty() ? zero_of_.end() : zero_of_.find(data_.datum[row]);
    return (axis_->values[row] - (zero == zero_of_.end() ? 0 : zero->second)) * nm_per_unit_;
  }

 private:
  const Dataset& data_;
  const DatasetColumn* axis_ = nullptr;
  double nm_per_unit_ = 0;
  std::map<std::int64_t, double> zero_of_;
};

}  // namespace

void add_measured(const Dataset& data, std::span<const DatumRecord> datums, ComparedRun& out) {
  if (data.time_s.empty()) return;
  const WayOfAxis way(data, datums);
  for (const auto& column : data.columns) {
    const bool pose = is_pose(column.channel);
    if (!pose && !is_compared_temperature(column.channel)) continue;
    const bool length = pose && is_length(column.channel.unit);
    const SummaryUnit summary = summary_unit(column.channel.unit);
    ComparedSeries series;
    series.name = column.channel.symbol;
    series.unit = pose ? summary.unit : "K";
    double first = kMissing;
    for (std::size_t row = 0; row < data.rows; ++row) {
      if (data.is_excluded(row)) continue;
      if (pose && (data.zero.empty() || data.zero[row] == 0)) continue;
      const double value = column.values[row] * summary.factor - (length ? way.at(row) : 0);
      if (is_missing(value)) continue;
      if (is_missing(first)) first = value;
      series.hours.push_back((data.time_s[row] - data.time_s.front()) / 3600);
      series.values.push_back(value - first);
    }
    finish(std::move(series), pose ? out.zero : out.temperatures);
  }
}

void add_residuals(const ModelResiduals& residuals, ComparedRun& out) {
  const auto& data = residuals.data;
  if (data.time_s.empty()) {
    out.residual_trouble = "its points have no times";
    return;
  }
  for (const auto& output : residuals.outputs) {
    ComparedSeries series;
    series.name = output.channel.symbol;
    series.unit = summary_unit(output.channel.unit).unit;
    for (std::size_t row = 0; row < data.rows; ++row) {
      if (data.is_excluded(row) || is_missing(output.values[row])) continue;
      series.hours.push_back((data.time_s[row] - data.time_s.front()) / 3600);
      series.values.push_back(output.values[row]);
    }
    finish(std::move(series), out.residuals);
  }
}

}  // namespace driftwise::application
