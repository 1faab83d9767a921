#include "server/diagnosis/rows/problem.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <random>
#include <set>

#include "server/calibration/design/predict.h"
#include "server/calibration/linear/undetermined.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/diagnosis/rows/catalogue_units.h"
#include "server/diagnosis/rows/held_out_gain.h"
#include "server/diagnosis/rows/hidden_readings.h"
#include "server/diagnosis/rows/predicted_pose.h"
#include "server/diagnosis/rows/rows_needed.h"
#include "server/effects/term_order.h"

namespace driftwise::diagnosis {
namespace {

constexpr std::size_t kBlocks = 10, kEvery = 5;
constexpr std::size_t kGapShare = 4;         // of a block, left out of the fit on either side of it
constexpr std::size_t kMostLearned = 20000;  // rows of one such fit: more tell it nothing new
constexpr double kDetermined = 1e-9;         // of a column's length beyond the others

Result<void> check_time(const Dataset& dataset) {
  for (std::size_t i = 1; i < dataset.time_s.size(); ++i)
    if (dataset.time_s[i] < dataset.time_s[i - 1])
      return fail(ErrorCode::invalid_argument, reasons::kTimeRunsBack,
                  "row " + std::to_string(i + 1) + " was measured at time_s " +
                      effects::number_text(dataset.time_s[i]) + ", before row " +
                      std::to_string(i) + " at " + effects::number_text(dataset.time_s[i - 1]) +
                      ": sort the file by time");
  return {};
}

// "1", datum(2), ...: what a fit always has in.
std::vector<effects::Term> constants(const Dataset& dataset) {
  std::vector<effects::Term> terms = {effects::Term{}};
  std::map<std::int64_t, int> seen;
  for (const auto id : dataset.datum) {
    const auto next = static_cast<int>(seen.size()) + 1;
    if (seen.emplace(id, next).second && next > 1) terms.push_back(effects::datum_term(next));
  }
  return terms;
}

bool begins(const Dataset& dataset, std::size_t row, std::size_t before) {
  return (!dataset.run.empty() && dataset.run[row] != dataset.run[before]) ||
         (!dataset.datum.empty() && dataset.datum[row] != dataset.datum[before]);
}

double time_of(const Dataset& dataset, std::size_t row) {
  return dataset.time_s.empty() ? static_cast<double>(row) : dataset.time_s[row];
}

Result<void> add_outputs(const Dataset& dataset, const std::vector<std::string>& symbols,
                         Problem& problem) {
  for (const auto& symbol : symbols) {
    const auto* column = dataset.find(symbol);
    if (column == nullptr)
      return fail(ErrorCode::invalid_argument, reasons::kUnknownChannel,
                  "the data have no column for output " + symbol);
    const auto unit = summary_unit(column->channel.unit);
    problem.outputs.push_back(
        {column->channel, unit.unit, unit.factor,
         Eigen::Map<const Eigen::VectorXd>(column->values.data(),
                                           static_cast<Eigen::Index>(column->values.size())) *
             unit.factor});
  }
  return {};
}

// Blocks of time, each with the rows that its fit learns from: all others but those within a
// quarter of a block. A block without which a term of the baseline is not determined has no
// held-out figure.
std::vector<Fold> folds_of(const Problem& problem) {
  const auto rank = [&problem](const std::vector<std::size_t>& rows) {
    Eigen::MatrixXd x = rows_of(problem.base_columns, rows);
    x = x * x.colwise().norm().cwiseMax(1e-300).cwiseInverse().asDiagonal();
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(x);
    qr.setThreshold(kDetermined);
    return qr.rank();
  };
  const std::size_t n = problem.learn.size();
  const Eigen::Index whole = rank(problem.learn);
  std::vector<Fold> folds;
  std::mt19937_64 random(1);
  for (std::size_t k = 0; k < kBlocks; ++k) {
    const std::size_t begin = k * n / kBlocks, end = (k + 1) * n / kBlocks,
                      gap = (end - begin) / kGapShare;
    Fold fold;
    for (std::size_t i = 0; i < n; ++i) {
      if (i >= begin && i < end)
        fold.judge.push_back(problem.learn[i]);
      else if (i + gap < begin || i >= end + gap)
        fold.learn.push_back(problem.learn[i]);
    }
    if (fold.judge.empty() || fold.learn.size() < problem.base.size() + kRowsBeyondBase) continue;
    if (fold.learn.size() > kMostLearned) {  // drawn, not every so many: a plan may be periodic
      std::vector<std::size_t> drawn;
      std::ranges::sample(fold.learn, std::back_inserter(drawn), kMostLearned, random);
      fold.learn = std::move(drawn);
    }
    if (rank(fold.learn) == whole) folds.push_back(std::move(fold));
  }
  return folds;
}

// Takes the rows of datums without a calibration row out. Data of validation rows only have none
// that knows better.
void take_unknown_datums(const Dataset& dataset, std::vector<std::size_t>& rows) {
  std::set<std::int64_t> known;
  for (const std::size_t row : rows)
    if (!dataset.datum.empty() && dataset.set_of(row) == PointSet::calibration)
      known.insert(dataset.datum[row]);
  if (!known.empty())
    std::erase_if(rows, [&](std::size_t row) { return !known.contains(dataset.datum[row]); });
}

Result<void> divide_rows(const Dataset& dataset, Judging judging, Problem& problem) {
  std::vector<std::size_t> complete;
  for (std::size_t row = 0; row < dataset.rows; ++row) {
    if (!dataset.is_excluded(row) && is_complete(problem, row)) complete.push_back(row);
  }
  take_unknown_datums(dataset, complete);
  std::size_t validation = 0;
  for (const std::size_t row : complete)
    validation += dataset.set_of(row) == PointSet::validation ? 1 : 0;
  // validation rows only: there is nothing to learn from but them
  problem.judged_by_validation = validation > 0 && validation < complete.size();
  for (std::size_t i = 0; i < complete.size(); ++i) {
    const bool judges =
        problem.judged_by_validation
            ? dataset.set_of(complete[i]) == PointSet::validation
            : judging == Judging::apart && i * kBlocks / complete.size() % kEvery == kEvery - 2;
    (judges ? problem.judge : problem.learn).push_back(complete[i]);
  }
  DRIFTWISE_RETURN_IF_ERROR(check_rows_needed(problem));
  problem.judged_in_turn = !problem.judged_by_validation && judging == Judging::in_turn;
  if (problem.judged_in_turn) {
    problem.folds = folds_of(problem);
    for (const auto& fold : problem.folds)
      problem.judge.insert(problem.judge.end(), fold.judge.begin(), fold.judge.end());
  } else {
    problem.folds = {{problem.learn, problem.judge}};
  }
  return {};
}

Result<void> give_back_fast_temperatures(Problem& problem) {
  Eigen::MatrixXd outputs(std::ssize(problem.learn), std::ssize(problem.outputs));
  for (std::size_t o = 0; o < problem.outputs.size(); ++o)
    outputs.col(static_cast<Eigen::Index>(o)) = rows_of(problem.outputs[o].measured, problem.learn);
  if (!problem.prepared.give_back_followed(problem.base, problem.base_columns, outputs,
                                           problem.learn))
    return {};
  DRIFTWISE_TRY(auto columns, problem.prepared.columns(problem.base));
  problem.base_columns = std::move(columns);
  return {};
}

void leave_out_undetermined(Problem& problem, std::size_t constants) {
  const auto gone = calibration::undetermined(rows_of(problem.base_columns, problem.learn),
                                              static_cast<Eigen::Index>(constants));
  std::vector<effects::Term> kept;
  Eigen::Index count = 0;
  for (std::size_t k = 0; k < gone.size(); ++k) {
    if (gone[k] != 0) {
      problem.undetermined.push_back(problem.base[k]);
      continue;
    }
    kept.push_back(problem.base[k]);
    problem.base_columns.col(count++) = problem.base_columns.col(static_cast<Eigen::Index>(k));
  }
  problem.base = std::move(kept);
  problem.base_columns.conservativeResize(Eigen::NoChange, count);
}

Result<void> check_variation(const Problem& problem) {
  for (const auto& output : problem.outputs) {
    const Eigen::VectorXd values = rows_of(output.measured, problem.learn);
    if (values.maxCoeff() > values.minCoeff()) continue;
    return fail(ErrorCode::invalid_argument, reasons::kNothingVaries,
                "column " + output.channel.name() + " is " +
                    effects::number_text(values[0] / output.factor) +
                    " in every row: there is nothing to explain");
  }
  return {};
}

bool reads(const std::vector<effects::Term>& terms, const std::string& symbol) {
  return std::ranges::any_of(terms, [&](const effects::Term& term) {
    const auto symbols = effects::symbols_of(term);
    return std::ranges::find(symbols, symbol) != symbols.end();
  });
}

double spread_of(const Eigen::VectorXd& values) {
  return (values.array() - values.mean()).matrix().norm();
}

// Largest part of a motor's spread that the baseline leaves at the measured pose.
double share_left(const Problem& problem) {
  double share = 0;
  for (const auto& output : problem.outputs) {
    if (!is_motor_symbol(output.channel.symbol)) continue;
    const Eigen::VectorXd left =
        rows_of(residuals(problem, output, problem.base_columns), problem.learn);
    const double spread = spread_of(rows_of(output.measured, problem.learn));
    if (spread > 0) share = std::max(share, left.norm() / spread);
  }
  return share;
}

// Noise of a pose coordinate that would leave as much, in its unit.
double noise_of(const Problem& problem, const std::vector<double>& values, double share) {
  const Eigen::VectorXd learned = rows_of(
      Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size())),
      problem.learn);
  return share * spread_of(learned) / std::sqrt(static_cast<double>(problem.learn.size()));
}

// Of the two readings of a position, motor and pose, one has the noise. Where the pose repeats
// itself exactly and the motors do not, it is the motors': their path is what the baseline predicts
// from the pose. A coarse display repeats itself too, in more places than were commanded.
// Everywhere else the pose is what the motors predict. The pose coordinates that repeat exactly
// where the motors were measured; none: they were not.
std::vector<const DatasetColumn*> exact_pose(const Problem& problem) {
  const Dataset& data = problem.data();
  const double share = share_left(problem);
  bool motors_repeat = true;
  std::vector<const std::vector<double>*> motors, pose;  // that repeat, of the pose
  std::vector<const DatasetColumn*> exact;
  for (const auto& column : data.columns) {
    if (is_motor_symbol(column.channel.symbol)) {
      motors_repeat = motors_repeat && repeats_exactly(data, column.values);
      motors.push_back(&column.values);
    } else if (is_coordinate(problem, column.channel) && repeats_exactly(data, column.values) &&
               !is_read_in_steps(data, column.values, noise_of(problem, column.values, share))) {
      pose.push_back(&column.values);
      exact.push_back(&column);
    }
  }
  const bool outputs_are_motors = std::ranges::all_of(
      problem.outputs, [](const auto& output) { return is_motor_symbol(output.channel.symbol); });
  if (motors_repeat && !(outputs_are_motors && different_places(pose) < different_places(motors)))
    exact.clear();
  return exact;
}

// True: a pose coordinate is a prediction from here on.
bool predict_coordinates(Problem& problem) {
  constexpr double kKnown = 0.02;  // of the path's spread left
  const Dataset& data = problem.data();
  const auto exact = exact_pose(problem);
  if (exact.empty()) {
    bool any = false;
    for (const auto& column : data.columns) {
      const std::string& symbol = column.channel.symbol;
      if (!is_coordinate(problem, column.channel)) continue;
      const auto predicted = predicted_coordinate(data, symbol);
      if (!predicted) continue;
      problem.prepared.set_coordinate(symbol, *predicted);
      any = true;
    }
    return any;
  }
  // As commanded, and not at the mean of positions that lie near one another: a fine scan at a few
  // positions of a long stroke has all phases of a wave there.
  for (const auto* column : exact)
    problem.prepared.set_coordinate(column->channel.symbol, column->values);
  for (const auto& output : problem.outputs) {
    if (!is_motor_symbol(output.channel.symbol)) continue;
    const Eigen::VectorXd left = residuals(problem, output, problem.base_columns);
    const double spread = spread_of(rows_of(output.measured, problem.learn));
    if (!(rows_of(left, problem.learn).norm() < kKnown * spread)) continue;
    const auto measured = problem.data().values_of(output.channel.symbol);
    std::vector<double> path(measured.begin(), measured.end());
    for (std::size_t row = 0; row < path.size(); ++row)
      if (const double miss = left[static_cast<Eigen::Index>(row)]; std::isfinite(miss))
        path[row] -= miss / output.factor;
    problem.prepared.set_path(output.channel.symbol, path);
  }
  return false;
}

// The baseline at the predicted pose, beside causes at the predicted pose. The difference between a
// polynomial of the measured pose and one of the predicted pose is the measurement's noise times a
// slope: with both in one fit, two polynomials that agree at every place of a lattice spell out the
// noise. What the baseline misses at the measured pose stays what it is.
Result<void> lay_on_prediction(Problem& problem) {
  const Eigen::MatrixXd at_measured = std::move(problem.base_columns);
  DRIFTWISE_RETURN_IF_ERROR(solve_for_pose(problem, at_measured));
  DRIFTWISE_TRY(auto at_predicted, problem.prepared.columns(problem.base));
  problem.base_columns = std::move(at_predicted);
  for (Eigen::Index i = 0; i < at_measured.rows(); ++i)
    if (!problem.base_columns.row(i).allFinite()) problem.base_columns.row(i) = at_measured.row(i);
  Eigen::MatrixXd learned = rows_of(at_measured, problem.learn);
  const Eigen::RowVectorXd inverse = learned.colwise().norm().cwiseMax(1e-300).cwiseInverse();
  learned = learned * inverse.asDiagonal();
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(learned);
  for (auto& output : problem.outputs) {
    const Eigen::VectorXd b =
        inverse.transpose().cwiseProduct(qr.solve(rows_of(output.measured, problem.learn)));
    output.measured += (problem.base_columns - at_measured) * b;
  }
  return {};
}

}  // namespace

bool is_coordinate(const Problem& problem, const Channel& channel) {
  return is_pose_symbol(channel.symbol) &&
         (channel.unit == "mm" || reads(problem.base, channel.symbol));
}

bool is_complete(const Problem& problem, std::size_t row) {
  const auto at = static_cast<Eigen::Index>(row);
  return problem.base_columns.row(at).allFinite() &&
         std::ranges::all_of(problem.outputs, [at](const ProblemOutput& output) {
           return std::isfinite(output.measured[at]);
         });
}

std::vector<std::string> Problem::output_symbols() const {
  if (!given_outputs.empty()) return given_outputs;
  std::vector<std::string> symbols;
  for (const auto& output : outputs) symbols.push_back(output.channel.symbol);
  return symbols;
}

Eigen::MatrixXd rows_of(const Eigen::MatrixXd& columns, const std::vector<std::size_t>& rows) {
  Eigen::MatrixXd taken(static_cast<Eigen::Index>(rows.size()), columns.cols());
  for (std::size_t i = 0; i < rows.size(); ++i)
    taken.row(static_cast<Eigen::Index>(i)) = columns.row(static_cast<Eigen::Index>(rows[i]));
  return taken;
}

Eigen::MatrixXd Problem::learned(const Eigen::MatrixXd& all) const {
  if (rows_per_block == 1) return rows_of(all, learn);
  Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(timeline.rows(), all.cols());
  Eigen::VectorXd count = Eigen::VectorXd::Zero(timeline.rows());
  for (std::size_t i = 0; i < learn.size(); ++i) count[static_cast<Eigen::Index>(block_of[i])] += 1;
  for (Eigen::Index j = 0; j < all.cols(); ++j)
    for (std::size_t i = 0; i < learn.size(); ++i)
      sums(static_cast<Eigen::Index>(block_of[i]), j) +=
          all(static_cast<Eigen::Index>(learn[i]), j);
  return count.cwiseInverse().asDiagonal() * sums;
}

Eigen::MatrixXd Problem::series() const {
  Eigen::MatrixXd result(timeline.rows(), static_cast<Eigen::Index>(outputs.size()));
  for (std::size_t o = 0; o < outputs.size(); ++o)
    result.col(static_cast<Eigen::Index>(o)) = learned(outputs[o].measured);
  return result;
}

Eigen::MatrixXd Problem::searched() const {
  Eigen::MatrixXd result = series();
  for (std::size_t o = 0; o < outputs.size(); ++o)
    if (outputs[o].tails.size() > 0)
      result.col(static_cast<Eigen::Index>(o)) -= learned(outputs[o].tails);
  return result;
}

void Problem::spread_rows(const Eigen::VectorXd& sd, std::optional<std::size_t> output) {
  if (row_sd.size() == 0)
    row_sd = Eigen::MatrixXd::Ones(sd.size(), static_cast<Eigen::Index>(outputs.size()));
  for (Eigen::Index o = 0; o < row_sd.cols(); ++o)
    if (!output || static_cast<std::size_t>(o) == *output)
      row_sd.col(o) = row_sd.col(o).cwiseProduct(sd).eval();
}

void Problem::leave_out(const std::vector<std::size_t>& rows) {
  const auto gone = [&rows](std::size_t row) { return std::ranges::binary_search(rows, row); };
  std::erase_if(learn, gone);
  std::erase_if(judge, gone);
  for (auto& fold : folds) {
    std::erase_if(fold.learn, gone);
    std::erase_if(fold.judge, gone);
  }
}

namespace {

// Time between rows from which no block bridges it: a night is no interval between readings. 0:
// intervals differ so much that none is a pause.
double pause_between(const Dataset& dataset, const std::vector<std::size_t>& rows) {
  constexpr double kUsualSteps = 3, kFew = 0.05;  // of the rows
  std::vector<double> steps;
  for (std::size_t i = 1; i < rows.size(); ++i)
    steps.push_back(time_of(dataset, rows[i]) - time_of(dataset, rows[i - 1]));
  if (steps.empty()) return 0;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  const double pause_s = kUsualSteps * *middle;
  const auto pauses = std::ranges::count_if(steps, [&](double step) { return step > pause_s; });
  return static_cast<double>(pauses) <= kFew * static_cast<double>(rows.size()) ? pause_s : 0;
}

}  // namespace

void Problem::lay_blocks(std::size_t longest) {
  const Dataset& dataset = data();
  rows_per_block = (learn.size() + longest - 1) / longest;
  block_of.assign(learn.size(), 0);
  timeline = {};
  const double pause_s = rows_per_block > 1 ? pause_between(dataset, learn) : 0;
  std::vector<double> times, counts, firsts, lasts;
  for (std::size_t i = 0; i < learn.size(); ++i) {
    const bool restart = i == 0 || begins(dataset, learn[i], learn[i - 1]);
    const bool afresh =
        restart ||
        (pause_s > 0 && time_of(dataset, learn[i]) - time_of(dataset, learn[i - 1]) > pause_s);
    if (afresh || counts.back() >= static_cast<double>(rows_per_block)) {
      times.push_back(0);
      counts.push_back(0);
      firsts.push_back(time_of(dataset, learn[i]));
      lasts.push_back(0);
      timeline.restart.push_back(restart ? 1 : 0);
    }
    times.back() += time_of(dataset, learn[i]);
    lasts.back() = time_of(dataset, learn[i]);
    counts.back() += 1;
    block_of[i] = times.size() - 1;
  }
  timeline.time_s.resize(static_cast<Eigen::Index>(times.size()));
  for (std::size_t b = 0; b < times.size(); ++b)
    timeline.time_s[static_cast<Eigen::Index>(b)] = times[b] / counts[b];
  if (rows_per_block > 1) {
    const auto blocks = static_cast<Eigen::Index>(counts.size());
    timeline.readings = Eigen::Map<const Eigen::VectorXd>(counts.data(), blocks);
    timeline.span_s = Eigen::Map<const Eigen::VectorXd>(lasts.data(), blocks) -
                      Eigen::Map<const Eigen::VectorXd>(firsts.data(), blocks);
  }
  if (row_sd.size() == 0) return;
  timeline.sd = learned(row_sd.cwiseAbs2()).cwiseSqrt();
  // All outputs alike share what is worked out.
  if ((timeline.sd.colwise() - timeline.sd.col(0)).isZero(0))
    timeline.sd = Eigen::MatrixXd(timeline.sd.col(0));
}

Result<Problem> lay_out(const Dataset& given, const calibration::Candidates& baseline,
                        std::size_t longest, Judging judging) {
  const Dataset dataset = in_catalogue_units(given);
  DRIFTWISE_RETURN_IF_ERROR(check_time(dataset));
  if (baseline.outputs.empty())
    return fail(ErrorCode::invalid_argument, reasons::kNoOutput, "the baseline names no output");
  std::vector<effects::Term> base = constants(dataset);
  const std::size_t always = base.size();
  for (const auto& term : in_catalogue_units(baseline).terms)
    base.push_back(effects::canonical(term));
  for (const auto& symbol : baseline.outputs)
    if (dataset.find(symbol) == nullptr)
      return fail(ErrorCode::invalid_argument, reasons::kUnknownChannel,
                  "the data have no column for output " + symbol);
  if (dataset.time_s.empty())  // a lag in the baseline needs more than the order of rows
    DRIFTWISE_RETURN_IF_ERROR(calibration::raw_columns(dataset, base));
  Problem problem;
  problem.prepared = Prepared::of(dataset);
  problem.base = std::move(base);
  DRIFTWISE_RETURN_IF_ERROR(add_outputs(dataset, baseline.outputs, problem));
  DRIFTWISE_TRY(auto columns, problem.prepared.columns(problem.base));
  problem.base_columns = std::move(columns);
  DRIFTWISE_RETURN_IF_ERROR(divide_rows(dataset, judging, problem));
  DRIFTWISE_RETURN_IF_ERROR(check_variation(problem));
  DRIFTWISE_RETURN_IF_ERROR(give_back_fast_temperatures(problem));
  leave_out_undetermined(problem, always);
  if (predict_coordinates(problem)) DRIFTWISE_RETURN_IF_ERROR(lay_on_prediction(problem));
  DRIFTWISE_TRY(auto hidden, hidden_in(problem));
  problem.hidden = std::move(hidden);
  problem.lay_blocks(longest);
  return problem;
}

}  // namespace driftwise::diagnosis
