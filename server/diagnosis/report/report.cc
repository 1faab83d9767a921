#include "server/diagnosis/report/report.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <ranges>

#include "server/core/units.h"
#include "server/diagnosis/answer/u90.h"
#include "server/diagnosis/catalogue/linear_parameter.h"
#include "server/diagnosis/catalogue/parameter.h"
#include "server/diagnosis/growth/correction_reach.h"
#include "server/diagnosis/growth/motors_as_served.h"
#include "server/diagnosis/report/instrument_numbers.h"
#include "server/diagnosis/report/motor_figures.h"
#include "server/diagnosis/report/sentence.h"
#include "server/diagnosis/rows/held_out_gain.h"
#include "server/diagnosis/rows/weighted_fit.h"

namespace driftwise::diagnosis {
namespace {

constexpr double kShown2lnl = 8;      // of one output
constexpr double kOneAxis = 0.9;      // cosine: an error of several outputs is one coordinate's
constexpr double kKnownShare = 0.25;  // of a correction: how well it is known at least

// Which axis an instrument's error belongs to: the one whose own column is spread over the outputs
// as the error is, each output by its noise.
struct AlongAxis {
  std::string symbol;  // "" where the baseline has no coordinate
  std::string unit;    // mm or arcsec
  double shift = 0;    // of that coordinate, that gives the error's first column
  double alike = 0;    // cosine between the two, over the outputs
};
// sizes: of the error, an output a row, in summary units; an error of two phases has two columns.
AlongAxis axis_of(const Problem& problem, Eigen::MatrixXd sizes, const Eigen::VectorXd& noise_sd) {
  sizes = noise_sd.cwiseInverse().asDiagonal() * sizes;
  AlongAxis best;
  for (const auto& column : problem.data().columns) {
    const auto& symbol = column.channel.symbol;
    if (!is_coordinate(problem, column.channel)) continue;
    const auto along = slopes_along(problem, symbol);
    if (!along) continue;
    const Eigen::VectorXd slopes = along->cwiseQuotient(noise_sd);
    const Eigen::RowVectorXd across = slopes.transpose() * sizes;
    const double alike = across.norm() > 0 ? across.norm() / (slopes.norm() * sizes.norm()) : 0;
    if (alike > best.alike)
      best = {symbol, column.channel.unit, std::abs(across[0]) / slopes.squaredNorm(), alike};
  }
  return best;
}

// Full width of a play of a pose coordinate that every output shows through its slope: one number
// of all of them, each by its error. Empty where the baseline does not read the coordinate.
// coefficients, errors: of the play's column, per output in summary units per unit of the column.
std::optional<FoundParameter> width_along(const Problem& problem, const Cause& cause, double width,
                                          const Eigen::VectorXd& coefficients,
                                          const Eigen::VectorXd& errors) {
  const auto slopes = slopes_along(problem, cause.subject);
  if (!slopes) return std::nullopt;
  double own = 0, weight = 0;
  for (Eigen::Index o = 0; o < slopes->size(); ++o) {
    if (!(errors[o] > 0) || !std::isfinite(errors[o])) continue;
    own += (*slopes)[o] * coefficients[o] / std::pow(errors[o], 2);
    weight += std::pow((*slopes)[o] / errors[o], 2);
  }
  if (!(weight > 0)) return std::nullopt;
  const double value = width * std::abs(own / weight),
               reach = kSigmaToU90 * width / std::sqrt(weight);
  return FoundParameter{cause.parameter, value, Interval{value - reach, value + reach}, {}};
}

// A term is copied into formulas: a number of it has no more digits than the search tells apart.
std::vector<effects::Term> written_terms(const Cause& cause, const Named& named) {
  if (!has_values(cause)) return named.terms;
  std::vector<effects::Term> terms;
  for (const auto& value : named.values) {
    const auto written = with_parameter(value.terms, as_written(cause, value.parameter));
    terms.insert(terms.end(), written.begin(), written.end());
  }
  return terms;
}

Finding finding_of(const Problem& problem, const std::vector<Cause>& causes,
                   const Extension& extension, std::size_t index) {
  const Named& named = extension.named()[index];
  const Cause& cause = causes[named.cause];
  Finding finding{.cause = cause.id,
                  .subject = cause.subject,
                  .where = cause.where,
                  .applies_to = cause.applies_to,
                  .terms = written_terms(cause, named),
                  .p_adjusted = named.p_adjusted,
                  .log_likelihood_ratio = named.likelihood / 2};
  const bool any_angle = std::ranges::any_of(
      problem.outputs, [](const ProblemOutput& output) { return output.unit == "arcsec"; });
  const bool of_the_pose = cause.id == "probe_hysteresis";
  const bool is_width = of_the_pose || cause.linear == LinearParameter::width_nm ||
                        (cause.linear == LinearParameter::width_arcsec && any_angle);
  if (!cause.parameter.empty() && !is_width) {
    FoundParameter parameter{cause.parameter, named.values.front().parameter, {}, {}};
    if (auto curve = extension.profile_of(index)) {
      parameter.ci90 = curve->ci90;
      parameter.curve = std::move(curve->curve);
    }
    parameter.aliases = extension.aliases_of(index);
    finding.parameters.push_back(std::move(parameter));
    for (std::size_t v = 1; v < named.values.size(); ++v)
      finding.parameters.push_back(
          {number_name(v, cause.parameter, {}, 1), named.values[v].parameter, {}, {}});
  }
  const std::size_t of_one_value = named.values.front().terms.size();
  for (const std::size_t rival : named.rivals)
    finding.indistinguishable_from.push_back(name_of(causes[rival]));
  const Ground ground = extension.ground(index, extension.shapes());
  const auto on = acts_on(problem, cause);
  const Gain gain = extension.gain_where_it_acts(index, ground);
  const SoftBase base = extension.learned(index);
  const auto shown = static_cast<std::size_t>(
      std::ranges::count_if(gain.of_output, [](double one) { return one > kShown2lnl; }));
  Eigen::VectorXd error_of_play = Eigen::VectorXd::Zero(std::ssize(on));
  Eigen::MatrixXd coefficients = Eigen::MatrixXd::Zero(named.learned.cols(), std::ssize(on)),
                  errors = coefficients;
  std::vector<FoundParameter> of_outputs;
  for (std::size_t o = 0; o < problem.outputs.size(); ++o) {
    if (on[o] == 0) continue;
    const auto& output = problem.outputs[o];
    FindingOutput one{.output = output.channel.symbol, .unit = output.unit};
    one.gain_2lnl = gain.of_output[o];
    one.shown = one.gain_2lnl > kShown2lnl || (shown == 0 && named.share[o] > 0);
    const auto at = static_cast<Eigen::Index>(o);
    const double share = std::max(named.share[o], kPriorShares.back());
    const WeightedFit fit(
        problem, base, named.learned, o, ground.shape(gain.shape[o]),
        AddedPrior{ground.white_sd_with(gain, at), share * named.prior.typical.col(at)});
    Eigen::VectorXd added = Eigen::VectorXd::Zero(named.learned.rows());
    for (Eigen::Index k = 0; k < named.learned.cols(); ++k) {
      const double coefficient = fit.added_coefficient(k), error = fit.added_error(k);
      added += coefficient * named.learned.col(k);
      one.coefficients.push_back(coefficient / output.factor);
      coefficients(k, at) = coefficient;
      errors(k, at) = one.shown ? error : 0;
      if (k == 0) error_of_play[at] = error;
      const auto& term = named.terms[static_cast<std::size_t>(k)];
      const std::size_t v = static_cast<std::size_t>(k) / of_one_value;
      const double parameter_at = named.values[v].parameter;
      const auto number = output.unit == "nm" ? linear_number(cause.linear, term, parameter_at)
                          : output.unit == "arcsec"
                              ? linear_number_of_angle(cause.linear, term, parameter_at)
                              : LinearNumber{};
      if (number.name.empty() || !one.shown || !std::isfinite(error)) continue;
      const double value = coefficient * number.factor,
                   reach = kSigmaToU90 * error * std::abs(number.factor);
      FoundParameter parameter{
          number_name(v, number.name, term, of_one_value) + (shown > 1 ? "_" + one.output : ""),
          value,
          Interval{value - reach, value + reach},
          {}};
      // The motor chooses which side is positive; whether a play grows or shrinks it does not.
      const bool grows = k > 0 && term.factors.size() > 1;
      if (is_width && (grows ? fit.added_coefficient(0) : value) < 0) {
        parameter.value = -value;
        parameter.ci90 = Interval{-value - reach, -value + reach};
      }
      of_outputs.push_back(std::move(parameter));
    }
    if (cause.applies_to == effects::AppliesTo::correction)
      if (const auto reach = correction_reach(problem, named.terms, fit); reach) {
        one.correction_rms = reach->rms;
        one.correction_u90 = reach->u90;
      }
    // beyond what the rest of the simulation could do of it
    const Eigen::VectorXd beyond_rest =
        added - base.columns * base.columns.colPivHouseholderQr().solve(added);
    one.amplitude = std::sqrt(beyond_rest.squaredNorm() / static_cast<double>(added.size()));
    if (problem.judge.size() >= 4) {
      const auto held =
          held_out(problem, output, extension.described(o, index), extension.described(o));
      one.judge(held.before, held.after);
      one.u90_after_ci90 = held.u90_after_ci90;
      one.a90_after_ci90 = held.a90_after_ci90;
    }
    finding.outputs.push_back(std::move(one));
  }
  if (of_the_pose)
    if (const auto width = width_along(problem, cause, named.values.front().parameter,
                                       coefficients.row(0).transpose(), error_of_play))
      finding.parameters.push_back(*width);
  if (finding.subject.empty() && finding.outputs.size() == problem.outputs.size() &&
      cause.applies_to != effects::AppliesTo::robot) {
    const auto outputs = static_cast<Eigen::Index>(problem.outputs.size());
    Eigen::MatrixXd sizes = Eigen::MatrixXd::Zero(outputs, named.learned.cols());
    Eigen::VectorXd noise_sd(outputs);
    for (std::size_t o = 0; o < problem.outputs.size(); ++o) {
      const auto row = static_cast<Eigen::Index>(o);
      noise_sd[row] = extension.between_neighbours(o);
      for (std::size_t k = 0; k < finding.outputs[o].coefficients.size(); ++k) {
        const auto column = static_cast<Eigen::Index>(k);
        sizes(row, column) = finding.outputs[o].coefficients[k] * problem.outputs[o].factor *
                             named.learned.col(column).norm();
      }
    }
    const AlongAxis axis = axis_of(problem, sizes, noise_sd);
    finding.subject = axis.symbol;
    // One leg of six that slips, or whose counter loses counts, moves no pose coordinate alone.
    const Eigen::VectorXd shares = (noise_sd.cwiseInverse().asDiagonal() * sizes).rowwise().norm();
    Eigen::Index strongest = 0;
    const double most = shares.maxCoeff(&strongest);
    if (cause.applies_to == effects::AppliesTo::dataset && axis.alike <= kOneAxis &&
        most > kOneAxis * shares.norm())
      finding.subject = problem.outputs[static_cast<std::size_t>(strongest)].channel.symbol;
  }
  const bool is_jump = cause.linear == LinearParameter::size_nm;
  if ((cause.applies_to == effects::AppliesTo::correction || is_jump) && !of_the_pose)
    if (auto own = instrument_numbers(problem, cause, named, finding.subject, coefficients, errors))
      of_outputs = std::move(*own);
  finding.parameters.insert(finding.parameters.end(), std::make_move_iterator(of_outputs.begin()),
                            std::make_move_iterator(of_outputs.end()));
  if (cause.applies_to == effects::AppliesTo::dataset && cause.scale == ParameterScale::instant)
    for (std::size_t row = 0; row < problem.data().rows; ++row)
      if (problem.data().time_s[row] >= named.values.front().parameter) finding.rows.push_back(row);
  finding.sentence = sentence(finding);
  return finding;
}

// U90 of visits to one place about their mean, over the calibration rows.
std::optional<double> noise_floor(const Problem& problem, const Eigen::VectorXd& left) {
  constexpr double kPlaceMm = 1e-3;
  constexpr std::size_t kFewestRepeats = 10;
  std::vector<std::pair<std::vector<long>, std::size_t>> places;
  for (const std::size_t row : problem.learn) {
    std::vector<long> place;
    for (const auto& column : problem.data().columns) {
      const auto& symbol = column.channel.symbol;
      if (is_motor_symbol(symbol)) place.push_back(std::lround(column.values[row] / kPlaceMm));
      if (symbol == "force") place.push_back(std::lround(column.values[row] * 100));
    }
    if (place.empty()) return std::nullopt;
    places.emplace_back(std::move(place), row);
  }
  std::ranges::stable_sort(places, {}, [](const auto& one) { return one.first; });
  double squares = 0;
  std::size_t dof = 0;
  for (std::size_t i = 0; i < places.size();) {
    std::size_t end = i;
    double sum = 0;
    for (; end < places.size() && places[end].first == places[i].first; ++end)
      sum += left[static_cast<Eigen::Index>(places[end].second)];
    const double mean = sum / static_cast<double>(end - i);
    for (std::size_t k = i; k < end; ++k)
      squares += std::pow(left[static_cast<Eigen::Index>(places[k].second)] - mean, 2);
    dof += end - i - 1;
    i = end;
  }
  if (dof < kFewestRepeats) return std::nullopt;
  return kSigmaToU90 * std::sqrt(squares / static_cast<double>(dof));
}

}  // namespace

bool correction_is_uncertain(const Finding& finding) {
  return std::ranges::any_of(finding.outputs, [](const FindingOutput& one) {
    return one.correction_u90 && one.u90_before && *one.correction_u90 > *one.u90_before &&
           *one.correction_u90 > kKnownShare * kSigmaToU90 * one.correction_rms.value_or(0);
  });
}

std::vector<Finding> findings_of(const Problem& problem, const std::vector<Cause>& causes,
                                 const Extension& extension,
                                 const std::optional<CoordinateFrame>& frame) {
  std::vector<Finding> findings;
  for (std::size_t i = 0; i < extension.named().size(); ++i) {
    findings.push_back(finding_of(problem, causes, extension, i));
    if (frame)
      say_of_motors(*frame, problem, causes[extension.named()[i].cause], extension, i,
                    findings.back());
  }
  std::ranges::stable_sort(findings, std::ranges::greater{}, &Finding::log_likelihood_ratio);
  return findings;
}

namespace {

// Most of a coordinate's range that the sides of what reads it may be apart. An output that is a
// deviation hardly follows the coordinate: its sides would be metres of it.
constexpr double kMostOfRange = 0.1;

double range_of(const std::vector<double>& values, const std::vector<std::size_t>& rows) {
  const auto [low, high] = std::ranges::minmax(
      rows | std::views::transform([&](std::size_t row) { return values[row]; }));
  return high - low;
}

}  // namespace

Finding probe_hysteresis(const Problem& problem, const TwoSides& sides) {
  Finding finding{.cause = "probe_hysteresis",
                  .where = "instrument",
                  .applies_to = effects::AppliesTo::dataset,
                  .p_adjusted = std::max(std::exp(-sides.gain / 2), kSmallestP),
                  .log_likelihood_ratio = sides.gain / 2};
  Eigen::VectorXd noise_sd(sides.half.size());
  for (std::size_t o = 0; o < problem.outputs.size(); ++o)
    noise_sd[static_cast<Eigen::Index>(o)] =
        noise_between_neighbours(problem, o, problem.base_columns);
  const AlongAxis axis = axis_of(problem, sides.half, noise_sd);
  Eigen::Index largest = 0;
  sides.half.cwiseAbs().maxCoeff(&largest);
  const auto& output = problem.outputs[static_cast<std::size_t>(largest)];
  const auto* read = problem.data().find(axis.symbol);
  if (axis.alike > kOneAxis && read != nullptr &&
      2 * axis.shift < kMostOfRange * range_of(read->values, problem.learn)) {
    finding.subject = axis.symbol;
    const bool length = axis.unit == "mm";
    finding.parameters.push_back({length ? "width_nm" : "width_" + axis.unit,
                                  2 * axis.shift * (length ? kNmPerMm : 1),
                                  {},
                                  {}});
  } else {
    finding.subject = output.channel.symbol;
    finding.parameters.push_back(
        {"width_" + output.unit, 2 * std::abs(sides.half[largest]), {}, {}});
  }
  finding.sentence = sentence(finding);
  return finding;
}

namespace {

// Residuals of an output by the baseline and by the extended simulation: of every row, and of those
// that judge.
struct Left {
  Eigen::VectorXd before, after, judged_before, judged_after;
};

Left left_of(const Problem& problem, const Extension& extension, std::size_t o) {
  const auto& output = problem.outputs[o];
  const SoftBase now = extension.described(o);
  Left left{residuals_as_read(problem, output, problem.base_columns),
            residuals_as_read(problem, output, now),
            {},
            {}};
  if (problem.judge.size() < 4) return left;
  left.judged_before = judged_residuals(problem, output, problem.base_columns);
  left.judged_after = judged_residuals(problem, output, now);
  return left;
}

// The motors', of the coordinates'; after: each with what is said of it.
std::vector<Left> of_motors(const CoordinateFrame& frame, const Problem& problem,
                            const Extension& extension, const std::vector<Left>& coordinates) {
  std::vector<std::size_t> all(problem.data().rows);
  std::iota(all.begin(), all.end(), std::size_t{0});
  std::vector<Left> result(coordinates.size());
  const auto take = [&](Eigen::VectorXd Left::*part, const Eigen::MatrixXd& motors) {
    for (std::size_t o = 0; o < result.size(); ++o)
      result[o].*part = motors.col(static_cast<Eigen::Index>(o));
  };
  Eigen::MatrixXd before(problem.base_columns.rows(), std::ssize(coordinates));
  for (std::size_t c = 0; c < coordinates.size(); ++c)
    before.col(static_cast<Eigen::Index>(c)) = coordinates[c].before;
  take(&Left::before, frame.of_motors(before, all));
  take(&Left::after,
       motors_as_served(frame, problem, extension, all,
                        [&problem](const ProblemOutput& coordinate, const SoftBase& simulation) {
                          return residuals_as_read(problem, coordinate, simulation);
                        }));
  if (coordinates.front().judged_before.size() == 0) return result;
  take(&Left::judged_before, judged_motors_by_baseline(frame, problem));
  take(&Left::judged_after, judged_motors_as_served(frame, problem, extension));
  return result;
}

OutputSummary summary_of(const Problem& problem, const Dataset& dataset,
                         const ProblemOutput& output, const Left& left, const Ground& ground,
                         Eigen::Index at) {
  OutputSummary one{.output = output.channel.symbol, .unit = output.unit};
  one.before.assign(left.before.data(), left.before.data() + left.before.size());
  one.after.assign(left.after.data(), left.after.data() + left.after.size());
  const ErrorFigures learned_before = figures_of(rows_of(left.before, problem.learn)),
                     learned_after = figures_of(rows_of(left.after, problem.learn));
  one.u90_calibration_before = one.u90 = learned_before.u90;
  one.mean_calibration_before = one.mean = learned_before.mean;
  one.a90_calibration_before = one.a90 = learned_before.a90;
  one.u90_calibration_after = learned_after.u90;
  one.mean_calibration_after = learned_after.mean;
  one.a90_calibration_after = learned_after.a90;
  one.noise_floor_u90 = noise_floor(problem, left.after);
  if (left.judged_after.size() > 0) {
    const ErrorFigures judged_before = figures_of(left.judged_before),
                       judged_after = figures_of(left.judged_after);
    one.u90_validation_before = judged_before.u90;
    one.mean_validation_before = judged_before.mean;
    one.a90_validation_before = judged_before.a90;
    one.u90_validation_after = judged_after.u90;
    one.mean_validation_after = judged_after.mean;
    one.a90_validation_after = judged_after.a90;
  }
  one.noise_white_sd = ground.white_sd(at).value;
  one.noise_slow_sd = one.noise_white_sd * std::sqrt(ground.noise(at).slow_ratio);
  one.noise_tau_s = ground.noise(at).slow_ratio > 0 ? ground.noise(at).tau_s : 0;
  for (const auto& column : dataset.columns)
    if (column.channel.symbol != output.channel.symbol)
      one.explained_by.push_back(
          {column.channel.symbol, marginal_share(column.values, one.before)});
  if (!dataset.time_s.empty())
    one.explained_by.push_back({"time", marginal_share(dataset.time_s, one.before)});
  std::ranges::stable_sort(one.explained_by, std::ranges::greater{}, &Share::share);
  return one;
}

}  // namespace

std::vector<OutputSummary> outputs_of(const Problem& problem, const Dataset& dataset,
                                      const Extension& extension,
                                      const std::optional<CoordinateFrame>& frame) {
  std::vector<Left> left;
  for (std::size_t o = 0; o < problem.outputs.size(); ++o)
    left.push_back(left_of(problem, extension, o));
  if (frame) left = of_motors(*frame, problem, extension, left);
  SoftBase simulation = extension.learned();
  Eigen::MatrixXd series = problem.series();
  if (frame) {
    simulation = problem.learned(problem.base_columns);
    for (std::size_t o = 0; o < left.size(); ++o)
      series.col(static_cast<Eigen::Index>(o)) = problem.learned(left[o].after);
  }
  const Ground ground(frame ? problem.timeline.with_one_spread() : problem.timeline,
                      noise_grid(problem.timeline), simulation, series);
  std::vector<OutputSummary> outputs;
  for (std::size_t o = 0; o < left.size(); ++o)
    outputs.push_back(summary_of(problem, dataset, frame ? frame->motors[o] : problem.outputs[o],
                                 left[o], ground, static_cast<Eigen::Index>(o)));
  return outputs;
}

std::string extended_formula(const std::string& baseline, const std::vector<Finding>& findings) {
  std::string formula = baseline;
  std::vector<std::string> added;
  for (const auto& finding : findings)
    for (const auto& term : finding.terms) {
      const auto text = effects::notation(term);
      if (std::ranges::find(added, text) != added.end()) continue;
      added.push_back(text);
      formula += " + " + text;
    }
  return formula;
}

}  // namespace driftwise::diagnosis
