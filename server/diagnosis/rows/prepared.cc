#include "server/diagnosis/rows/prepared.h"

#include <algorithm>

#include "server/calibration/design/predict.h"
#include "server/diagnosis/rows/places.h"
#include "server/diagnosis/rows/smoothing.h"

namespace driftwise::diagnosis {
namespace {

bool is_wave_in_coordinate(const effects::Term& term) {
  return std::ranges::any_of(term.factors, [](const effects::Factor& factor) {
    const auto* call = std::get_if<effects::Call>(&factor);
    return call != nullptr && (call->effect == "sin" || call->effect == "cos");
  });
}

bool observes_path(const effects::Term& term) {
  return std::ranges::any_of(term.factors, [](const effects::Factor& factor) {
    const auto* call = std::get_if<effects::Call>(&factor);
    return call != nullptr && !call->symbols.empty() && is_motor_symbol(call->symbols.front());
  });
}

}  // namespace

Prepared Prepared::of(const Dataset& dataset) {
  Prepared prepared;
  prepared.data_ = dataset;
  std::vector<double> clock = dataset.time_s;
  if (clock.empty())
    for (std::size_t i = 0; i < dataset.rows; ++i) clock.push_back(static_cast<double>(i));
  std::vector<std::vector<double>> thermometers;
  for (const auto& column : prepared.data_.columns)
    if (is_structure_temperature(column.channel)) thermometers.push_back(column.values);
  thermometers = smoothed_together(clock, thermometers);
  std::size_t next = 0;
  for (auto& column : prepared.data_.columns)
    if (is_structure_temperature(column.channel)) column.values = std::move(thermometers[next++]);
  prepared.clocked_ = prepared.data_;
  prepared.clocked_.time_s = clock;
  prepared.at_places_ = prepared.clocked_;
  for (auto& column : prepared.at_places_.columns)
    if (is_pose_symbol(column.channel.symbol) || is_motor_symbol(column.channel.symbol))
      column.values = by_places(column.values);
  prepared.on_path_ = prepared.clocked_;
  return prepared;
}

// At its places: an axis that stands 30 nm from where it was sent, measured to 5 nm, otherwise has
// plays of 10 to 100 nm that only spell out the measurement's noise.
void Prepared::set_path(const std::string& symbol, const std::vector<double>& values) {
  const auto places = by_places(values);
  for (Dataset* data : {&on_path_, &at_places_})
    for (auto& column : data->columns)
      if (column.channel.symbol == symbol) column.values = places;
}

void Prepared::set_coordinate(const std::string& symbol, const std::vector<double>& values) {
  for (Dataset* data : {&clocked_, &on_path_, &at_places_})
    for (auto& column : data->columns)
      if (column.channel.symbol == symbol) column.values = values;
}

Result<Eigen::MatrixXd> Prepared::columns(const std::vector<effects::Term>& terms) const {
  const auto from = [&](const effects::Term& term) {
    if (is_wave_in_coordinate(term)) return &at_places_;
    return observes_path(term) ? &on_path_ : &clocked_;
  };
  Eigen::MatrixXd columns(static_cast<Eigen::Index>(data_.rows),
                          static_cast<Eigen::Index>(terms.size()));
  for (const Dataset* source : {&clocked_, &at_places_, &on_path_}) {
    std::vector<effects::Term> some;
    std::vector<Eigen::Index> places;
    for (std::size_t k = 0; k < terms.size(); ++k) {
      if (from(terms[k]) != source) continue;
      some.push_back(terms[k]);
      places.push_back(static_cast<Eigen::Index>(k));
    }
    if (some.empty()) continue;
    auto made = calibration::raw_columns(*source, some);
    if (!made || some.size() == terms.size()) return made;
    for (std::size_t k = 0; k < places.size(); ++k)
      columns.col(places[k]) = made->col(static_cast<Eigen::Index>(k));
  }
  return columns;
}

std::span<const double> Prepared::phase_values(const std::string& symbol) const {
  if (symbol.empty()) return clocked_.time_s;
  return at_places_.values_of(symbol);
}

}  // namespace driftwise::diagnosis
