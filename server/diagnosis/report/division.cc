#include "server/diagnosis/report/division.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "server/calibration/design/predict.h"
#include "server/core/data/dataset_parts.h"
#include "server/core/units.h"
#include "server/diagnosis/noise/noise_model.h"
#include "server/diagnosis/report/sentence.h"
#include "server/effects/term_order.h"

namespace driftwise::diagnosis {
namespace {

constexpr const char* kInstrumentPart = "instrument";
constexpr double kAnotherStart_k = 1, kStructure_s = 2 * 3600, kOfTheRun = 1.0 / 3;
constexpr double kOfTheSmaller = 0.25, kOfTheLarger = 0.1;
constexpr double kWorthARun = 0.5;  // of the U90 without it
constexpr double kRidge = 1e-9;     // of a column of length 1: the data do not determine it

enum class Side : std::uint8_t { rest, robot, instruments };

struct Column {
  effects::Term term;
  Side side = Side::rest;
  std::string name;  // of the side's list
};

std::string part_of(const Parts& parts, const std::string& symbol) {
  std::string part;
  for (const auto& [of, where] : parts)
    if (of == symbol) part = where;
  return part;
}

bool is_temperature(const Dataset& data, const std::string& symbol) {
  const auto* column = data.find(symbol);
  return column != nullptr && is_structure_temperature(column->channel);
}

// A thermal cause of the robot by a thermometer that is on an instrument.
bool is_of_an_instrument(const Parts& parts, const Cause& cause) {
  return cause.applies_to == effects::AppliesTo::robot && cause.id.starts_with("thermal_") &&
         part_of(parts, cause.subject) == kInstrumentPart;
}

std::vector<Column> columns_of(const Problem& problem, const std::vector<Cause>& causes,
                               const Extension& extension) {
  const Parts parts = parts_from(problem.data().metadata);
  std::vector<Column> columns;
  for (const auto& term : problem.base) {
    Column column{term, Side::rest, {}};
    for (const auto& symbol : effects::symbols_of(term)) {
      if (!is_temperature(problem.data(), symbol)) continue;
      const bool instrument = part_of(parts, symbol) == kInstrumentPart;
      if (column.side != Side::robot) column.side = instrument ? Side::instruments : Side::robot;
      if (column.name.empty()) column.name = symbol;
    }
    columns.push_back(std::move(column));
  }
  for (const auto& one : extension.named()) {
    const Cause& cause = causes[one.cause];
    const Side side = is_of_an_instrument(parts, cause)                    ? Side::instruments
                      : cause.applies_to == effects::AppliesTo::robot      ? Side::robot
                      : cause.applies_to == effects::AppliesTo::correction ? Side::instruments
                                                                           : Side::rest;
    for (const auto& term : one.terms) columns.push_back({term, side, name_of(cause)});
  }
  return columns;
}

std::vector<std::string> names_of(const std::vector<Column>& columns, Side side) {
  std::vector<std::string> names;
  for (const auto& column : columns)
    if (column.side == side && std::ranges::find(names, column.name) == names.end())
      names.push_back(column.name);
  return names;
}

std::vector<Eigen::Index> indices_of(const std::vector<Column>& columns, Side side) {
  std::vector<Eigen::Index> indices;
  for (std::size_t k = 0; k < columns.size(); ++k)
    if (columns[k].side == side) indices.push_back(static_cast<Eigen::Index>(k));
  return indices;
}

// The columns of the same plan with the structure begun at another temperature; those that read no
// temperature of the structure stay as they are.
Eigen::MatrixXd begun_elsewhere(const Problem& problem, const std::vector<Column>& columns,
                                Eigen::MatrixXd all) {
  const Parts parts = parts_from(problem.data().metadata);
  Dataset second = problem.prepared.conditions();
  const auto& time_s = second.time_s;
  const double tau_s = std::min(kStructure_s, kOfTheRun * (time_s.back() - time_s.front()));
  for (auto& column : second.columns) {
    const std::string& symbol = column.channel.symbol;
    if (!is_temperature(problem.data(), symbol) || part_of(parts, symbol) == kInstrumentPart)
      continue;
    for (std::size_t row = 0; row < second.rows; ++row)
      column.values[row] += kAnotherStart_k * std::exp(-(time_s[row] - time_s.front()) / tau_s);
  }
  for (std::size_t k = 0; k < columns.size(); ++k) {
    const auto read = effects::symbols_of(columns[k].term);
    if (std::ranges::none_of(read, [&](const std::string& symbol) {
          return is_temperature(problem.data(), symbol);
        }))
      continue;
    const auto made = calibration::raw_columns(second, {columns[k].term});
    if (made && made->allFinite()) all.col(static_cast<Eigen::Index>(k)) = made->col(0);
  }
  return all;
}

// Normal matrix of a posterior in units of the noise's variance, each column about its length.
struct Posterior {
  Eigen::MatrixXd normal;
  Eigen::VectorXd scale;

  Eigen::MatrixXd covariance(const std::vector<Eigen::Index>& of) const {
    Eigen::MatrixXd scaled =
        scale.cwiseInverse().asDiagonal() * normal * scale.cwiseInverse().asDiagonal();
    scaled.diagonal().array() += kRidge;
    const Eigen::MatrixXd inverse =
        scaled.ldlt().solve(Eigen::MatrixXd::Identity(normal.rows(), normal.cols()));
    const Eigen::MatrixXd whole =
        scale.cwiseInverse().asDiagonal() * inverse * scale.cwiseInverse().asDiagonal();
    return whole(of, of);
  }
  Eigen::VectorXd solve(const Eigen::VectorXd& along) const {
    Eigen::MatrixXd scaled =
        scale.cwiseInverse().asDiagonal() * normal * scale.cwiseInverse().asDiagonal();
    scaled.diagonal().array() += kRidge;
    return scaled.ldlt().solve(along.cwiseQuotient(scale)).cwiseQuotient(scale);
  }
};

Posterior posterior_of(Eigen::MatrixXd normal) {
  const Eigen::VectorXd scale = normal.diagonal().cwiseSqrt().cwiseMax(1e-300);
  return {std::move(normal), scale};
}

double rms_of(const Eigen::MatrixXd& columns, const Eigen::VectorXd& b) {
  const Eigen::MatrixXd counted = columns.rowwise() - columns.row(0);
  return std::sqrt((counted * b).squaredNorm() / static_cast<double>(counted.rows()));
}

double u90_of(const Eigen::MatrixXd& columns, const Eigen::MatrixXd& covariance) {
  const Eigen::MatrixXd counted = columns.rowwise() - columns.row(0);
  return kSigmaToU90 * std::sqrt((counted * covariance).cwiseProduct(counted).sum() /
                                 static_cast<double>(counted.rows()));
}

std::string the_first_few(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 4;
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kMost); ++i)
    text += (i == 0 ? "" : ", ") + names[i];
  if (names.size() > kMost) text += " and " + std::to_string(names.size() - kMost) + " more";
  return text;
}

}  // namespace

std::vector<Division> divisions_of(const Problem& problem, const std::vector<Cause>& causes,
                                   const Extension& extension) {
  const auto columns = columns_of(problem, causes, extension);
  const auto robot = indices_of(columns, Side::robot),
             instruments = indices_of(columns, Side::instruments);
  if (robot.empty() || instruments.empty() || problem.data().time_s.empty()) return {};
  const Ground ground = extension.ground(
      {}, extension.shapes().empty() ? noise_grid(problem.timeline) : extension.shapes());
  std::vector<Division> divisions;
  for (std::size_t o = 0; o < problem.outputs.size(); ++o) {
    const auto at = static_cast<Eigen::Index>(o);
    const WhiteSd noise = ground.white_sd(at);
    const SoftBase base = extension.described_whitened(o, noise);
    const auto acts = [&](const std::vector<Eigen::Index>& side) {
      return std::ranges::any_of(side, [&](Eigen::Index k) { return base.precision[k] < 1e299; });
    };
    if (!acts(robot) || !acts(instruments)) continue;
    const Whitener whitener(problem.timeline, ground.noise(at), at);
    Eigen::MatrixXd learned = problem.learned(base.columns);
    Eigen::MatrixXd again = problem.learned(begun_elsewhere(problem, columns, base.columns));
    for (std::size_t k = 0; k < columns.size(); ++k) {  // counted from the first row: small numbers
      if (columns[k].side == Side::rest) continue;
      const auto column = static_cast<Eigen::Index>(k);
      again.col(column).array() -= learned(0, column);
      learned.col(column).array() -= learned(0, column);
    }
    Eigen::MatrixXd white = learned, y = problem.learned(problem.outputs[o].measured);
    whitener.apply(white);
    whitener.apply(y);
    Eigen::MatrixXd normal = white.transpose() * white;
    normal.diagonal() += base.precision;
    const Posterior posterior = posterior_of(normal);
    const Eigen::VectorXd b = posterior.solve(white.transpose() * y.col(0));
    Division one;
    one.output = problem.outputs[o].channel.symbol;
    one.unit = problem.outputs[o].unit;
    one.robot_rms = rms_of(learned(Eigen::all, robot), b(robot));
    one.instrument_rms = rms_of(learned(Eigen::all, instruments), b(instruments));
    one.u90 =
        noise.value * u90_of(learned(Eigen::all, instruments), posterior.covariance(instruments));
    // The second run joined to the first one, with a zero of its own.
    Eigen::MatrixXd second(again.rows(), again.cols() + 1);
    second << again, Eigen::VectorXd::Ones(again.rows());
    whitener.apply(second);
    Eigen::MatrixXd both = second.transpose() * second;
    both.topLeftCorner(normal.rows(), normal.cols()) += normal;
    one.u90_with_another_start =
        noise.value * u90_of(learned(Eigen::all, instruments),
                             posterior_of(std::move(both)).covariance(instruments));
    one.robot = names_of(columns, Side::robot);
    one.instruments = names_of(columns, Side::instruments);
    if (std::isfinite(one.u90) && std::isfinite(one.u90_with_another_start))
      divisions.push_back(std::move(one));
  }
  return divisions;
}

bool is_divided(const Division& division) {
  return division.u90 <=
         std::max(kOfTheSmaller * std::min(division.robot_rms, division.instrument_rms),
                  kOfTheLarger * std::max(division.robot_rms, division.instrument_rms));
}

std::string sentence(const Division& division) {
  std::string text = division.output + ": " + size_text(division.robot_rms, division.unit) +
                     " rms of the correction rest on the robot (" + the_first_few(division.robot) +
                     "), " + size_text(division.instrument_rms, division.unit) +
                     " on instruments (" + the_first_few(division.instruments) + "); ";
  if (is_divided(division))
    return text + "they are told apart to " + size_text(division.u90, division.unit);
  text += "these data divide them to " + size_text(division.u90, division.unit) + " only";
  const std::string known = size_text(division.u90_with_another_start, division.unit);
  if (division.u90_with_another_start > kWorthARun * division.u90)
    return text + ", and the same points from another starting temperature would still leave " +
           known;
  return text +
         ". The same points once more, with the structure begun 1 K warmer or colder than it was "
         "and the air as it was, would divide them to " +
         known;
}

std::vector<std::string> thermal_causes_of_instruments(const Problem& problem,
                                                       const std::vector<Cause>& causes,
                                                       const Extension& extension) {
  const Parts parts = parts_from(problem.data().metadata);
  std::vector<std::string> sentences;
  for (const auto& one : extension.named()) {
    const Cause& cause = causes[one.cause];
    if (is_of_an_instrument(parts, cause))
      sentences.push_back(name_of(cause) + ": " + cause.subject +
                          " is on an instrument (its part in the data), so that what moves may be "
                          "the instrument's reading. In the robot's model it would move the robot "
                          "for an error of the instrument");
  }
  return sentences;
}

}  // namespace driftwise::diagnosis
