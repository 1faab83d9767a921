#include "server/application/look_back/compared_run.h"

#include <algorithm>

#include "server/stability/drift.h"

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

void finish(ComparedSeries series, std::vector<ComparedSeries>& into) {
  if (series.values.empty()) return;
  const auto [low, high] = std::minmax_element(series.values.begin(), series.values.end());
  series.range = *high - *low;
  for (const double value : series.values)
    series.mean += value / static_cast<double>(series.values.size());
  std::vector<double> time_s;
  for (const double hours : series.hours) time_s.push_back(3600 * hours);
  if (const auto drift = stability::drift_of(time_s, series.values))
    series.rate_per_h = drift->rate_per_h;
  thin(series);
  into.push_back(std::move(series));
}

bool is_length_unit(const Channel& channel) { return channel.unit == "mm"; }

// std columns of a run's points carry a unit of their own and no pose symbol.
bool is_pose(const Channel& channel) { return is_pose_symbol(channel.symbol); }

}  // namespace

void add_measured(const Dataset& data, ComparedRun& out) {
  if (data.time_s.empty()) return;
  for (const auto& column : data.columns) {
    const bool pose = is_pose(column.channel);
    const bool temperature = column.channel.unit == "degC";
    if (!pose && !temperature) continue;
    const double scale = pose && is_length_unit(column.channel) ? 1e6 : 1;
    ComparedSeries series;
    series.name = column.channel.symbol;
    series.unit = temperature ? "K" : is_length_unit(column.channel) ? "nm" : column.channel.unit;
    double first = kMissing;
    for (std::size_t row = 0; row < data.rows; ++row) {
      if (pose && (data.zero.empty() || data.zero[row] == 0)) continue;
      const double value = column.values[row];
      if (is_missing(value)) continue;
      if (is_missing(first)) first = value;
      series.hours.push_back((data.time_s[row] - data.time_s.front()) / 3600);
      series.values.push_back((value - first) * scale);
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
    series.unit = output.channel.unit == "mm" ? "nm" : output.channel.unit;
    for (std::size_t row = 0; row < data.rows; ++row) {
      if (is_missing(output.values[row])) continue;
      series.hours.push_back((data.time_s[row] - data.time_s.front()) / 3600);
      series.values.push_back(output.values[row]);
    }
    finish(std::move(series), out.residuals);
  }
}

}  // namespace driftwise::application
