#include "server/calibration/report/influence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <string_view>

#include "server/calibration/design/predict.h"
#include "server/core/try.h"
#include "server/effects/term_order.h"

namespace driftwise::calibration {
namespace {

using Eigen::Index;

bool is_pose_length(std::string_view symbol) {
  const auto local = without_robot(symbol);
  return local == "x" || local == "y" || local == "z";
}

constexpr std::array kPoseSymbols = {"x", "y", "z", "rx", "ry", "rz"};

// A length of a robot with an id goes with the coordinates of that robot: "ma.x" with "ma.ry".
std::string beside(const std::string& symbol, const char* coordinate) {
  const auto robot = robot_of(symbol);
  return robot.empty() ? coordinate : std::string(robot) + "." + coordinate;
}

// The output's derivative by one channel, as a sum of terms.
struct Derivative {
  std::vector<effects::Term> terms;
  std::vector<double> coefficients;
};
Derivative derivative_by(const OutputModel& output, const std::string& symbol) {
  Derivative out;
  for (std::size_t k = 0; k < output.terms.size(); ++k) {
    for (std::size_t f = 0; f < output.terms[k].factors.size(); ++f) {
      const auto* power = std::get_if<effects::Power>(&output.terms[k].factors[f]);
      if (power == nullptr || power->symbol != symbol) continue;
      effects::Term lower = output.terms[k];
      if (power->exponent == 1)
        lower.factors.erase(lower.factors.begin() + static_cast<std::ptrdiff_t>(f));
      else
        lower.factors[f] = effects::Power{symbol, power->exponent - 1};
      out.terms.push_back(std::move(lower));
      out.coefficients.push_back(output.coefficients[static_cast<Index>(k)] * power->exponent);
    }
  }
  return out;
}

// By how much a quantity has changed since the first of these rows of the same datum that has it,
// by row.
template <typename Values>
Eigen::VectorXd since_zero(const Excerpt& rows, const Values& values) {
  std::map<double, double> at_zero;
  Eigen::VectorXd change(static_cast<Index>(values.size()));
  for (Index i = 0; i < change.size(); ++i) {
    const auto row = static_cast<std::size_t>(i);
    const double value = values[static_cast<decltype(values.size())>(i)];
    if (is_missing(value)) {
      change[i] = kMissing;
      continue;
    }
    change[i] = value - at_zero.try_emplace(rows.datum()[row], value).first->second;
  }
  return change;
}

// Correlation of each row's noise with that of the row before the first: the zero's.
Eigen::VectorXd kept_since_zero(const Excerpt& rows, const NoiseSpectrum& noise) {
  Eigen::VectorXd kept = Eigen::VectorXd::Zero(rows.size());
  for (const auto& part : noise.slow)
    for (Index i = 0; i < kept.size(); ++i)
      kept[i] += part.variance / noise.variance() *
                 std::exp(-static_cast<double>(rows.place(i) + 1) / part.rows);
  return kept;
}

// Rows of a calibration that must have a reading of what an error goes with. Fewer rows give no
// influence.
bool are_enough(Index readings, Index rows, std::size_t unknowns) {
  constexpr double kFewest = 0.1;
  return readings > static_cast<Index>(unknowns) &&
         static_cast<double>(readings) >= kFewest * static_cast<double>(rows);
}

std::vector<std::string> symbols_in(const OutputModel& output) {
  std::vector<std::string> out;
  for (const auto& term : output.terms)
    for (const auto& symbol : effects::symbols_of(term))
      if (symbol != "datum" && std::ranges::find(out, symbol) == out.end()) out.push_back(symbol);
  return out;
}

}  // namespace

std::vector<Index> rows_read(const Eigen::VectorXd& shape) {
  std::vector<Index> rows;
  for (Index i = 0; i < shape.size(); ++i)
    if (!is_missing(shape[i])) rows.push_back(i);
  return rows;
}

std::vector<std::pair<std::string, Eigen::VectorXd>> error_shapes(const Excerpt& rows,
                                                                  const NoiseSpectrum& noise,
                                                                  const std::string& symbol,
                                                                  std::size_t unknowns) {
  std::vector<std::pair<std::string, Eigen::VectorXd>> out = {
      {"1", Eigen::VectorXd::Ones(rows.size())}};
  if (is_pose_symbol(without_robot(symbol)) && noise.variance() > 0)
    out.emplace_back("zero", kept_since_zero(rows, noise));
  if (!is_pose_length(symbol)) return out;
  for (const char* by : kPoseSymbols)
    if (const auto* column = rows.find(beside(symbol, by)))
      out.emplace_back(column->channel.name(), rows.values(*column));
  if (!rows.time_s().empty()) out.emplace_back("h", since_zero(rows, rows.time_s()) / 3600);
  for (const auto* thermometer : rows.thermometers())
    out.emplace_back(thermometer->channel.name(), since_zero(rows, rows.values(*thermometer)));
  std::erase_if(out, [&](const auto& one) {
    const auto readings = static_cast<Index>(rows_read(one.second).size());
    return readings < rows.size() && !are_enough(readings, rows.size(), unknowns);
  });
  return out;
}

Result<std::vector<Influence>> influences_of(const Excerpt& rows, const Projection& projection,
                                             const NoiseSpectrum& noise,
                                             const OutputModel& output) {
  std::vector<Influence> out;
  std::map<std::vector<Index>, Projection> over_some;
  for (const auto& symbol : symbols_in(output)) {
    const auto derivative = derivative_by(output, symbol);
    if (derivative.terms.empty()) continue;
    DRIFTWISE_TRY(const auto lower, rows.columns(derivative.terms));
    const Eigen::VectorXd slope = combine(
        lower,
        Eigen::Map<const Eigen::VectorXd>(derivative.coefficients.data(),
                                          static_cast<Index>(derivative.coefficients.size())));
    for (const auto& [by, shape] : error_shapes(rows, noise, symbol, output.terms.size())) {
      const auto read = rows_read(shape);
      const bool whole = read.size() == static_cast<std::size_t>(shape.size());
      const Eigen::VectorXd error = slope.cwiseProduct(shape)(read);
      if (!whole && !over_some.contains(read)) over_some.emplace(read, projection.over(read));
      const Projection& of_rows = whole ? projection : over_some.at(read);
      out.push_back({rows.find(symbol)->channel.name(), by,
                     std::sqrt(error.squaredNorm() / static_cast<double>(error.size())),
                     of_rows.coefficients(error)});
    }
  }
  return out;
}

Result<void> add_influences(const Dataset& dataset, const std::vector<std::size_t>& rows,
                            const std::string& weight_symbol, const NoiseSpectrum& noise,
                            OutputModel& output) {
  constexpr std::size_t kEnough = 4000;
  if (rows.size() <= output.terms.size()) return {};
  const Excerpt excerpt(dataset, rows, output, kEnough);
  DRIFTWISE_TRY(auto columns, excerpt.columns(output.terms));
  const auto* weights = weight_symbol.empty() ? nullptr : excerpt.find(weight_symbol);
  const Projection projection(std::move(columns), output.terms,
                              weights == nullptr ? Eigen::VectorXd() : excerpt.values(*weights));
  DRIFTWISE_TRY(auto influences, influences_of(excerpt, projection, noise, output));
  output.influences = std::move(influences);
  return {};
}

std::optional<std::string> sparse_readings(const Dataset& dataset,
                                           const std::vector<std::size_t>& rows,
                                           const std::vector<OutputModel>& outputs) {
  constexpr double kFew = 0.1;
  std::set<std::string> lengths;
  std::size_t terms = 0;
  for (const auto& output : outputs) {
    terms = std::max(terms, output.terms.size());
    for (const auto& symbol : symbols_in(output))
      if (is_pose_length(symbol)) lengths.insert(symbol);
  }
  std::string named, left_out;
  for (const auto& column : dataset.columns) {
    if (column.channel.unit != "degC" && std::ranges::none_of(lengths, [&](const auto& length) {
          return std::ranges::any_of(kPoseSymbols, [&](const char* by) {
            return beside(length, by) == column.channel.symbol;
          });
        }))
      continue;
    const auto missing =
        std::ranges::count_if(rows, [&](auto row) { return is_missing(column.values[row]); });
    const auto all = static_cast<Index>(rows.size());
    if (lengths.empty() || static_cast<double>(missing) <= kFew * static_cast<double>(all))
      continue;
    auto& list = are_enough(all - missing, all, terms) ? named : left_out;
    list += (list.empty() ? "" : ", ") + column.channel.name() + " in " + std::to_string(missing) +
            " of " + std::to_string(all);
  }
  if (named.empty() && left_out.empty()) return std::nullopt;
  std::string sentence = "calibration rows without a reading: ";
  if (!named.empty())
    sentence += named + " (the uncertainty that goes with it is from the other rows)";
  if (!left_out.empty())
    sentence += (named.empty() ? "" : "; ") + left_out +
                " (too few are left: the uncertainty of a target lacks what goes with it)";
  return sentence;
}

}  // namespace driftwise::calibration
