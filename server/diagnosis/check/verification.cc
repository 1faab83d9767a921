#include "server/diagnosis/check/verification.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>

#include "server/calibration/datum_zeros.h"
#include "server/calibration/design/predict.h"
#include "server/calibration/model/model_units.h"
#include "server/core/reasons.h"
#include "server/core/text/quantity_text.h"
#include "server/core/try.h"
#include "server/core/unit_conversion.h"

namespace driftwise::diagnosis {
namespace {

constexpr std::string_view kTarget = "_target";

struct Coordinate {
  const DatasetColumn* measured = nullptr;
  std::vector<double> targets;    // in the measured channel's unit
  std::vector<double> positions;  // the same, as runs are compared by: see comparable
};

// Wanted coordinates by symbol, comparable.
using Position = std::map<std::string, double>;

std::string run_name(RunId run) { return "run " + std::to_string(run.value); }

// Unit that targets of one kind are compared in, whatever unit a run states them in.
std::string unit_of_positions(const std::string& unit) {
  return unit == "degC" ? "K" : summary_unit(unit).unit;
}

// Steps of a thousandth of a nanometre or millionth of an arcsecond: 35 mm and 0.035 m are one
// position, though 0.035 * 1e9 is not 35000000 to the last bit.
double comparable(double value, const std::string& unit) {
  const double per_unit = is_length(unit) ? 1e3 : 1e6;
  return std::round(value * per_unit);
}

// Errors: UNITS_DISAGREE (units of two kinds).
Result<Coordinate> coordinate_of(const RunToVerify& run, const DatasetColumn& measured,
                                 const DatasetColumn& target) {
  const auto to_measured = unit_conversion(target.channel.unit, measured.channel.unit);
  if (!to_measured)
    return fail(ErrorCode::invalid_argument, reasons::kUnitsDisagree,
                run_name(run.run) + " gives " + target.channel.symbol + " in " +
                    target.channel.unit + " and " + measured.channel.symbol + " in " +
                    measured.channel.unit +
                    ", which cannot be converted: expected target and measurement in units of one "
                    "kind, such as mm and um; import the file with a mapping that names the unit "
                    "(docs/import.md)");
  const std::string unit = unit_of_positions(target.channel.unit);
  DRIFTWISE_TRY(const auto to_position, unit_conversion(target.channel.unit, unit));
  Coordinate found{&measured, {}, {}};
  for (const double value : target.values) {
    found.targets.push_back((*to_measured)(value));
    found.positions.push_back(comparable(to_position(value), unit));
  }
  return found;
}

Result<std::vector<Coordinate>> coordinates_of(const RunToVerify& run) {
  std::vector<Coordinate> found;
  std::string unmeasured;
  for (const auto& column : run.data.columns) {
    const std::string& symbol = column.channel.symbol;
    if (!symbol.ends_with(kTarget)) continue;
    const std::string axis = symbol.substr(0, symbol.size() - kTarget.size());
    if (const auto* measured = run.data.find(axis)) {  // a set-up measures some of the coordinates
      DRIFTWISE_TRY(auto coordinate, coordinate_of(run, *measured, column));
      found.push_back(std::move(coordinate));
    } else {
      unmeasured += (unmeasured.empty() ? "" : ", ") + column.channel.name();
    }
  }
  if (!found.empty()) return found;
  if (!unmeasured.empty())
    return fail(ErrorCode::invalid_argument, reasons::kUnknownChannel,
                run_name(run.run) + " has the targets " + unmeasured +
                    ", but measured none of these coordinates");
  // One axis: the position wanted is the motor coordinate commanded.
  const auto *x = run.data.find("x"), *commanded = run.data.find("q1_cmd");
  if (x != nullptr && commanded != nullptr && run.data.find("q2") == nullptr &&
      run.data.find("y") == nullptr) {
    DRIFTWISE_TRY(auto coordinate, coordinate_of(run, *x, *commanded));
    found.push_back(std::move(coordinate));
    return found;
  }
  return fail(ErrorCode::invalid_argument, reasons::kNoTargets,
              run_name(run.run) +
                  " has no wanted poses (columns x_target_mm ...): verify a run of a trajectory of "
                  "poses, such as `driftwise run start poses.csv --compensate`");
}

// Rows outside the range of a model, and which channels left it.
struct OutsideRows {
  std::vector<char> is_outside;
  std::vector<std::string> why;
};
Result<OutsideRows> outside_of(const calibration::Model* model, const Dataset& as_measured,
                               const std::vector<std::size_t>& rows) {
  OutsideRows found{std::vector<char>(as_measured.rows, 0), {}};
  if (model == nullptr) return found;
  DRIFTWISE_TRY(const Dataset data, calibration::in_model_units(*model, as_measured));
  for (const auto& range : model->domain) {
    const auto values = data.values_of(range.channel.symbol);
    if (values.empty() || range.channel.symbol.starts_with("q")) continue;
    const double slack = 1e-3 * (range.max - range.min);  // a boundary is visited with its noise
    bool above = false, below = false;
    for (const std::size_t row : rows) {
      const bool over = values[row] > range.max + slack, under = values[row] < range.min - slack;
      above |= over;
      below |= under;
      if (over || under) found.is_outside[row] = 1;
    }
    if (above) found.why.push_back(range.channel.name() + " above " + digits_text(range.max, 5));
    if (below) found.why.push_back(range.channel.name() + " below " + digits_text(range.min, 5));
  }
  return found;
}

// Per row and coordinate what the axes' own misses did to the pose, in the coordinate's unit: J^-1
// (q - q commanded), J from the model by central differences, all of it in the model's units.
// Empty: cannot be said.
Result<std::vector<std::vector<double>>> shares_of_holding(
    const RunToVerify& run, const std::vector<Coordinate>& coordinates,
    const std::vector<std::size_t>& rows) {
  const auto n = static_cast<Eigen::Index>(coordinates.size());
  if (run.model == nullptr || !run.compensated || run.model->outputs.size() != coordinates.size())
    return std::vector<std::vector<double>>();
  DRIFTWISE_TRY(const Dataset data, calibration::in_model_units(*run.model, run.data));
  std::vector<const DatasetColumn*> held, commanded;
  for (const auto& output : run.model->outputs) {
    held.push_back(data.find(output.channel.symbol));
    commanded.push_back(data.find(output.channel.symbol + "_cmd"));
    if (held.back() == nullptr || commanded.back() == nullptr)
      return std::vector<std::vector<double>>();
  }
  const Dataset base = calibration::in_first_datum(data, run.model->datum_zeros);
  std::vector<Eigen::MatrixXd> slopes(rows.size(), Eigen::MatrixXd::Zero(n, n));
  for (Eigen::Index k = 0; k < n; ++k) {
    const auto& axis =
        *data.find(coordinates[static_cast<std::size_t>(k)].measured->channel.symbol);
    double low = INFINITY, high = -INFINITY;
    for (const std::size_t row : rows) {
      const double value = axis.values[row];
      low = std::min(low, value), high = std::max(high, value);
    }
    const double step = std::max(1e-9, 1e-4 * (high - low));
    std::vector<Eigen::VectorXd> sides[2];
    for (const int side : {0, 1}) {
      Dataset moved = base;
      for (auto& column : moved.columns)
        if (column.channel.symbol == axis.channel.symbol)
          for (double& value : column.values) value += side == 0 ? -step : step;
      for (const auto& output : run.model->outputs) {
        auto predicted = calibration::predict(moved, output);
        if (!predicted) return std::vector<std::vector<double>>();
        sides[side].push_back(std::move(*predicted));
      }
    }
    for (std::size_t i = 0; i < rows.size(); ++i)
      for (Eigen::Index o = 0; o < n; ++o) {
        const auto at = static_cast<std::size_t>(o);
        const auto row = static_cast<Eigen::Index>(rows[i]);
        slopes[i](o, k) = (sides[1][at][row] - sides[0][at][row]) / (2 * step);
      }
  }
  std::vector<std::vector<double>> shares(coordinates.size(),
                                          std::vector<double>(data.rows, kMissing));
  std::vector<double> per_model_unit;
  for (const auto& one : coordinates) {
    const auto& channel = one.measured->channel;
    DRIFTWISE_TRY(const auto convert,
                  calibration::to_model_unit(channel, data.find(channel.symbol)->channel));
    per_model_unit.push_back(convert.divisor / convert.factor);
  }
  for (std::size_t i = 0; i < rows.size(); ++i) {
    Eigen::VectorXd missed(n);
    for (Eigen::Index o = 0; o < n; ++o) {
      const auto at = static_cast<std::size_t>(o);
      missed[o] = held[at]->values[rows[i]] - commanded[at]->values[rows[i]];
    }
    const Eigen::VectorXd share = slopes[i].partialPivLu().solve(missed);
    for (std::size_t k = 0; k < coordinates.size(); ++k)
      shares[k][rows[i]] = share[static_cast<Eigen::Index>(k)] * per_model_unit[k];
  }
  return shares;
}

struct RunRows {
  VerifiedRun run;
  std::vector<std::size_t> rows;    // of the dataset
  std::vector<Position> positions;  // wanted, per row
};

Result<RunRows> rows_to_verify(const RunToVerify& run, const calibration::Model* range) {
  DRIFTWISE_TRY(const auto coordinates, coordinates_of(run));
  RunRows judged;
  judged.run.run = run.run;
  judged.run.compensated = run.compensated;
  judged.run.with = run.with;
  for (std::size_t row = 0; row < run.data.rows; ++row) {
    if (run.data.is_excluded(row)) continue;
    const bool whole = std::ranges::all_of(coordinates, [row](const Coordinate& one) {
      return std::isfinite(one.measured->values[row]) && std::isfinite(one.targets[row]);
    });
    if (!whole) continue;
    if (!run.data.zero.empty() && run.data.zero[row] != 0) {
      ++judged.run.rows_zero;
      continue;
    }
    judged.rows.push_back(row);
    auto& position = judged.positions.emplace_back();
    for (const auto& one : coordinates) position[one.measured->channel.symbol] = one.positions[row];
  }
  if (judged.rows.size() < 2)
    return fail(ErrorCode::invalid_argument, reasons::kTooFewRows,
                run_name(run.run) + " has " + std::to_string(judged.rows.size()) +
                    " points with target and measurement, returns to zero not counted: at least 2 "
                    "are needed");
  DRIFTWISE_TRY(const auto outside, outside_of(range, run.data, judged.rows));
  judged.run.rows = static_cast<std::int64_t>(judged.rows.size());
  judged.run.outside = outside.why;
  for (const std::size_t row : judged.rows) judged.run.rows_outside += outside.is_outside[row];
  DRIFTWISE_TRY(const auto shares, shares_of_holding(run, coordinates, judged.rows));
  for (std::size_t k = 0; k < coordinates.size(); ++k) {
    const auto& channel = coordinates[k].measured->channel;
    const auto& measured = coordinates[k].measured->values;
    const SummaryUnit summary = summary_unit(channel.unit);
    VerifiedCoordinate one{channel, summary.unit, {}, {}, {}, {}, {}, 0, 0};
    one.errors.assign(run.data.rows, kMissing);
    std::vector<double> inside, beyond, all, by_model;
    for (const std::size_t row : judged.rows) {
      const double error = (coordinates[k].targets[row] - measured[row]) * summary.factor;
      one.errors[row] = error;
      all.push_back(error);
      (outside.is_outside[row] != 0 ? beyond : inside).push_back(error);
      // An axis that stands too far forward makes the pose so, and the error less.
      if (!shares.empty()) by_model.push_back(error + shares[k][row] * summary.factor);
      if (std::abs(error) > std::abs(one.largest)) {
        one.largest = error;
        one.largest_row = row;
      }
    }
    one.all = error_figures(all);
    one.inside = error_figures(inside);
    one.outside = error_figures(beyond);
    if (!shares.empty()) one.by_model = error_figures(by_model);
    judged.run.coordinates.push_back(std::move(one));
  }
  return judged;
}

// The same coordinate of another run, whose figures are in the same summary unit; the units that
// the two were measured in may differ.
const VerifiedCoordinate* same_coordinate(const VerifiedRun& run, const VerifiedCoordinate& as) {
  for (const auto& one : run.coordinates)
    if (one.channel.symbol == as.channel.symbol && one.unit == as.unit) return &one;
  return nullptr;
}

VerifiedChange change_of(const RunRows& run, const RunRows& against) {
  VerifiedChange change{run.run.run, against.run.run, 0, {}};
  // By what was wanted, which both trajectories state; repeats by their count.
  std::map<Position, std::vector<std::size_t>> visits;
  for (std::size_t i = 0; i < against.rows.size(); ++i)
    visits[against.positions[i]].push_back(against.rows[i]);
  std::vector<std::size_t> own, other;
  for (std::size_t i = 0; i < run.rows.size(); ++i) {
    const auto at = visits.find(run.positions[i]);
    if (at == visits.end() || at->second.empty()) continue;
    own.push_back(run.rows[i]);
    other.push_back(at->second.front());
    at->second.erase(at->second.begin());
  }
  change.positions = own.size() < 2 ? 0 : static_cast<std::int64_t>(own.size());
  const auto& own_rows = change.positions > 0 ? own : run.rows;
  const auto& other_rows = change.positions > 0 ? other : against.rows;
  const auto figures = [](const VerifiedCoordinate& of, const std::vector<std::size_t>& rows) {
    std::vector<double> errors;
    for (const std::size_t row : rows) errors.push_back(of.errors[row]);
    return error_figures(errors);
  };
  for (const auto& one : run.run.coordinates) {
    const auto* before = same_coordinate(against.run, one);
    JudgedAccuracy judged{one.channel.symbol, one.unit, JudgedRows::fresh, figures(one, own_rows),
                          std::nullopt};
    if (before != nullptr) judged.before = figures(*before, other_rows);
    change.coordinates.push_back(std::move(judged));
  }
  return change;
}

}  // namespace

Result<Verification> verify_runs(std::span<const RunToVerify> runs,
                                 const calibration::Model* range) {
  Verification result;
  const calibration::Model* common = range;
  for (const auto& run : runs)
    if (common == nullptr) common = run.model.get();
  std::vector<RunRows> judged;
  for (const auto& run : runs) {
    const auto* own = range != nullptr ? range : run.model != nullptr ? run.model.get() : common;
    DRIFTWISE_TRY(auto one, rows_to_verify(run, own));
    judged.push_back(std::move(one));
  }
  for (std::size_t i = 1; i < judged.size(); ++i)
    result.changes.push_back(change_of(judged[0], judged[i]));
  if (!result.changes.empty()) {
    result.heading = heading_of(result.changes.front().coordinates);
  } else if (!judged.empty()) {
    std::vector<JudgedAccuracy> all;
    for (const auto& one : judged[0].run.coordinates)
      all.push_back({one.channel.symbol, one.unit, JudgedRows::fresh, one.all, std::nullopt});
    result.heading = heading_of(all);
  }
  for (auto& one : judged) result.runs.push_back(std::move(one.run));
  return result;
}

}  // namespace driftwise::diagnosis
