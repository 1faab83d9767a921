#include "server/diagnosis/rows/prepared.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "server/calibration/design/predict.h"
#include "server/diagnosis/rows/places.h"
#include "server/diagnosis/rows/smoothing.h"
#include "server/effects/direct_symbols.h"
#include "server/effects/term_order.h"

namespace driftwise::diagnosis {
namespace {

bool is_wave_in_coordinate(const effects::Term& term) {
  return std::ranges::any_of(term.factors, [](const effects::Factor& factor) {
    const auto* call = std::get_if<effects::Call>(&factor);
    return call != nullptr && (call->effect == "sin" || call->effect == "cos");
  });
}

// A rate over at most this many typical steps of the rows is the derivative at the row; over less
// than the second it is that of the readings as they are.
constexpr double kDerivativeSteps = 1.5, kOfReadingsSteps = 0.75;

struct Derivative {
  std::string temperature;
  bool of_readings = false;  // not of the smoothed ones
};

// The temperature whose derivative the term is.
std::optional<Derivative> derivative_of(const effects::Term& term, double step_s) {
  if (term.factors.size() != 1) return {};
  const auto* call = std::get_if<effects::Call>(&term.factors.front());
  if (call == nullptr || call->effect != "rate" ||
      !(call->parameters.front().value <= kDerivativeSteps * step_s))
    return {};
  return Derivative{call->symbols.front(),
                    call->parameters.front().value <= kOfReadingsSteps * step_s};
}

double typical_step_s(const std::vector<double>& clock) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < clock.size(); ++i)
    if (clock[i] > clock[i - 1]) steps.push_back(clock[i] - clock[i - 1]);
  if (steps.empty()) return 0;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::ranges::nth_element(steps, middle);
  return *middle;
}

// Per hour, of the parabola through a row and the rows next to it that have a value; of the line
// where there is one on one side only.
Eigen::VectorXd derivative_per_h(const std::vector<double>& time_s,
                                 std::span<const double> values) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  constexpr double kSecondsPerHour = 3600;
  const auto slope = [&](std::size_t from, std::size_t to) {
    return (values[to] - values[from]) / (time_s[to] - time_s[from]);
  };
  Eigen::VectorXd result(static_cast<Eigen::Index>(values.size()));
  for (std::size_t i = 0; i < values.size(); ++i) {
    std::size_t before = i, after = i;
    while (before > 0 && !(std::isfinite(values[before]) && time_s[before] < time_s[i])) --before;
    while (after + 1 < values.size() &&
           !(std::isfinite(values[after]) && time_s[after] > time_s[i]))
      ++after;
    const bool has_before = std::isfinite(values[before]) && time_s[before] < time_s[i];
    const bool has_after = std::isfinite(values[after]) && time_s[after] > time_s[i];
    double per_s = kNone;
    if (!std::isfinite(values[i]))
      per_s = kNone;
    else if (has_before && has_after) {
      const double back_s = time_s[i] - time_s[before], ahead_s = time_s[after] - time_s[i];
      per_s = (ahead_s * slope(before, i) + back_s * slope(i, after)) / (back_s + ahead_s);
    } else if (has_before)
      per_s = slope(before, i);
    else if (has_after)
      per_s = slope(i, after);
    result[static_cast<Eigen::Index>(i)] = kSecondsPerHour * per_s;
  }
  return result;
}

}  // namespace

Prepared Prepared::of(const Dataset& dataset) {
  Prepared prepared;
  prepared.data_ = dataset;
  prepared.coarse_ = estimate_between_steps(prepared.data_);
  prepared.readings_ = prepared.data_;
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
  prepared.step_s_ = typical_step_s(clock);
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

bool Prepared::give_back_followed(const std::vector<effects::Term>& base,
                                  const Eigen::MatrixXd& base_columns,
                                  const Eigen::MatrixXd& outputs,
                                  const std::vector<std::size_t>& rows) {
  const auto learned = [&](std::span<const double> values) {
    Eigen::VectorXd taken(std::ssize(rows));
    for (std::size_t i = 0; i < rows.size(); ++i)
      taken[static_cast<Eigen::Index>(i)] = values[rows[i]];
    return taken;
  };
  const auto reads = [](const effects::Term& term, const std::string& symbol) {
    const auto symbols = effects::symbols_of(term);
    return std::ranges::find(symbols, symbol) != symbols.end();
  };
  const Eigen::MatrixXd columns = base_columns(rows, Eigen::all);
  Eigen::MatrixXd shapes = Eigen::MatrixXd::Ones(columns.rows(), 1);
  for (const auto& [channel, values] : data_.columns) {
    if (!is_pose_symbol(channel.symbol) && !is_motor_symbol(channel.symbol)) continue;
    if (std::ranges::none_of(base, [&](const auto& term) { return reads(term, channel.symbol); }))
      continue;
    const Eigen::VectorXd shape = learned(values);
    shapes.conservativeResize(Eigen::NoChange, shapes.cols() + 1);
    shapes.rightCols(1) = (shape.array() - shape.mean()).matrix();
  }
  std::map<std::string, double> shares;
  for (const auto& [channel, values] : readings_.columns) {
    if (!is_structure_temperature(channel)) continue;
    const Eigen::VectorXd smooth = learned(data_.values_of(channel.symbol)),
                          taken = learned(values) - smooth;
    if (!taken.allFinite()) continue;
    std::vector<Eigen::Index> others;
    for (std::size_t k = 0; k < base.size(); ++k)
      if (!reads(base[k], channel.symbol)) others.push_back(static_cast<Eigen::Index>(k));
    const double share =
        share_followed(columns(Eigen::all, others), outputs, smooth, taken, shapes);
    if (share > 0) shares[channel.symbol] = share;
  }
  for (Dataset* data : {&data_, &clocked_, &on_path_, &at_places_})
    for (auto& [channel, values] : data->columns)
      if (const auto found = shares.find(channel.symbol); found != shares.end())
        for (std::size_t i = 0; i < values.size(); ++i)
          values[i] += found->second * (readings_.values_of(channel.symbol)[i] - values[i]);
  return !shares.empty();
}

Result<Eigen::MatrixXd> Prepared::columns(const std::vector<effects::Term>& terms) const {
  const auto from = [&](const effects::Term& term) {
    if (is_wave_in_coordinate(term)) return &at_places_;
    return effects::reads_path(term) ? &on_path_ : &clocked_;
  };
  Eigen::MatrixXd columns(static_cast<Eigen::Index>(data_.rows),
                          static_cast<Eigen::Index>(terms.size()));
  for (std::size_t k = 0; k < terms.size(); ++k)
    if (const auto one = derivative_of(terms[k], step_s_))
      columns.col(static_cast<Eigen::Index>(k)) = derivative_per_h(
          clocked_.time_s, (one->of_readings ? readings_ : clocked_).values_of(one->temperature));
  for (const Dataset* source : {&clocked_, &at_places_, &on_path_}) {
    std::vector<effects::Term> some;
    std::vector<Eigen::Index> places;
    for (std::size_t k = 0; k < terms.size(); ++k) {
      if (from(terms[k]) != source || derivative_of(terms[k], step_s_)) continue;
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
