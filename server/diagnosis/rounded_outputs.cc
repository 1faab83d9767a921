#include "server/diagnosis/rounded_outputs.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>

#include "server/core/text/quantity_text.h"
#include "server/core/try.h"
#include "server/diagnosis/noise/robust.h"

namespace driftwise::diagnosis {
namespace {

constexpr std::size_t kFewestRounded = 16;
constexpr double kOffTheGrid = 1e-6;   // of a step, off a whole number of them
constexpr double kSmallest = 1e-8;     // of the range, of a step
constexpr double kNoiseOfAStep = 0.5;  // above it rounding errors are as good as independent
constexpr double kNoiseAlone = 0.2;    // by the baseline alone: more may be what is to be found
// Robust standard deviation of readings about what is simulated, in steps: 0.37 where rounding is
// all there is. More: something else is larger.
constexpr double kMostSpread = 0.8;
constexpr double kLeastSpread = 0.01;    // less: nominal values, as they are
constexpr double kSamePlace = 1;         // step, of what is foretold
constexpr double kKolmogorovAt1 = 1.63;  // times 1/sqrt(count), of the largest distance, level 1 %
constexpr double kSmallestNoise = 0.02;  // of a step
constexpr double kBeside = 1.5;          // steps
constexpr std::size_t kFewestVisits = 3;
constexpr int kRounds = 60;
constexpr double kFar = 6;  // standard deviations, beyond which a step's nearer edge is taken

double density(double z) { return std::exp(-z * z / 2) / std::sqrt(2 * std::numbers::pi); }
double below(double z) { return std::erfc(-z / std::numbers::sqrt2) / 2; }

// A standard normal value known to lie between two.
struct Truncated {
  double mean = 0, variance = 0;
};
Truncated truncated(double low, double high) {
  if (low > kFar) return {low, 0};
  if (high < -kFar) return {high, 0};
  const double chance = std::max(below(high) - below(low), 1e-300);
  const double mean = (density(low) - density(high)) / chance;
  const double square = 1 + (low * density(low) - high * density(high)) / chance;
  return {mean, std::max(square - mean * mean, 0.0)};
}

double drawn(double low, double high, std::mt19937_64& random) {
  if (low > kFar) return low;
  if (high < -kFar) return high;
  const double p = std::uniform_real_distribution<double>(below(low), below(high))(random);
  double from = std::max(low, -kFar - 1), to = std::min(high, kFar + 1);
  for (int k = 0; k < 50; ++k) (below((from + to) / 2) < p ? from : to) = (from + to) / 2;
  return (from + to) / 2;
}

struct Law {
  Eigen::VectorXd foretold;
  double sd = 0;
};

// In steps.
double spread_about(const Eigen::VectorXd& foretold, const Eigen::VectorXd& readings, double step) {
  const Eigen::VectorXd off = readings - foretold;
  return robust_sd({off.data(), off.data() + off.size()}) / step;
}

// Simulation and noise behind readings that are rounded to `step`, by expectation and maximisation.
// Nothing where they spread too far about the simulation: most data end there.
std::optional<Law> behind(const Eigen::MatrixXd& simulation, const Eigen::VectorXd& readings,
                          double step) {
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(simulation);
  qr.setThreshold(1e-10);
  const Eigen::MatrixXd basis =
      qr.householderQ() * Eigen::MatrixXd::Identity(simulation.rows(), qr.rank());
  const auto fitted = [&](const Eigen::VectorXd& v) {
    return Eigen::VectorXd(basis * (basis.transpose() * v));
  };
  const auto dof = static_cast<double>(std::max<Eigen::Index>(readings.size() - qr.rank(), 1));
  Law law{fitted(readings), 0};
  if (spread_about(law.foretold, readings, step) > kMostSpread) return std::nullopt;
  law.sd = std::max((readings - law.foretold).norm() / std::sqrt(dof), kSmallestNoise * step);
  Eigen::VectorXd mean = readings;
  for (int round = 0; round < kRounds; ++round) {
    double variance = 0;
    for (Eigen::Index i = 0; i < readings.size(); ++i) {
      const Truncated one = truncated((readings[i] - step / 2 - law.foretold[i]) / law.sd,
                                      (readings[i] + step / 2 - law.foretold[i]) / law.sd);
      mean[i] = law.foretold[i] + law.sd * one.mean;
      variance += law.sd * law.sd * one.variance;
    }
    law.foretold = fitted(mean);
    law.sd = std::max(std::sqrt(((mean - law.foretold).squaredNorm() + variance) / dof),
                      kSmallestNoise * step);
  }
  return law;
}

struct Step {
  std::string channel;   // that is read in it
  double size = 0;       // of the output, in its summary unit; 0: none
  bool is_grid = false;  // what is set goes in whole steps too
};

// True: the values differ by whole steps of another channel, in its unit.
bool go_in_steps_of(const DatasetColumn& read, double step, const DatasetColumn& set) {
  constexpr double kOffAStep = 1e-3;
  const double per_unit =
      summary_unit(set.channel.unit).factor / summary_unit(read.channel.unit).factor / step;
  return std::ranges::all_of(set.values, [&](double value) {
    const double steps = (value - set.values.front()) * per_unit;
    return !std::isfinite(steps) || std::abs(steps - std::round(steps)) < kOffAStep;
  });
}

// The coordinates that the baseline reads as they are.
std::vector<const DatasetColumn*> coordinates_read(const Problem& problem, const Dataset& given) {
  std::vector<const DatasetColumn*> result;
  for (const auto& term : problem.base) {
    const auto* power =
        term.factors.size() == 1 ? std::get_if<effects::Power>(&term.factors.front()) : nullptr;
    if (power == nullptr || power->exponent != 1) continue;
    if (!is_pose_symbol(power->symbol) && !is_motor_symbol(power->symbol)) continue;
    if (const auto* column = given.find(power->symbol)) result.push_back(column);
  }
  return result;
}

// A motor's discrepancy is as coarse as the pose coordinate that the baseline reads, times its
// slope; of several the coarsest, where no other one is nearly as coarse.
Step step_behind_motor(const Problem& problem, const ProblemOutput& output, const Dataset& given) {
  constexpr double kNearlyAsCoarse = 0.3;
  const Eigen::MatrixXd x = rows_of(problem.base_columns, problem.learn);
  const Eigen::VectorXd lengths = x.colwise().norm().cwiseMax(1e-300).transpose();
  const Eigen::MatrixXd scaled = x * lengths.cwiseInverse().asDiagonal();
  const Eigen::VectorXd b =
      scaled.colPivHouseholderQr().solve(rows_of(output.measured, problem.learn));
  Step coarsest;
  double second = 0;
  for (std::size_t t = 0; t < problem.base.size(); ++t) {
    const auto& factors = problem.base[t].factors;
    const auto* power =
        factors.size() == 1 ? std::get_if<effects::Power>(&factors.front()) : nullptr;
    if (power == nullptr || power->exponent != 1 || !is_pose_symbol(power->symbol)) continue;
    const auto* column = given.find(power->symbol);
    const auto* laid = problem.data().find(power->symbol);
    if (column == nullptr || laid == nullptr) continue;
    const auto at = static_cast<Eigen::Index>(t);
    const double per_unit =
        summary_unit(column->channel.unit).factor / summary_unit(laid->channel.unit).factor;
    const double step = decimal_step(column->values);
    const double size = std::abs(b[at] / lengths[at]) * per_unit * step;
    second = std::max(second, std::min(size, coarsest.size));
    if (size > coarsest.size)
      coarsest = {column->channel.name(), size,
                  go_in_steps_of(*column, step, *given.find(output.channel.symbol))};
  }
  return second > kNearlyAsCoarse * coarsest.size ? Step{} : coarsest;
}

// True: values are repeated, and none is read a step beside another. A reading that scatters by a
// part of a step comes out in the next one too; positions of a plan do not.
bool are_set(const std::vector<double>& values, double step) {
  std::vector<double> different;
  for (const double value : values)
    if (std::isfinite(value)) different.push_back(value);
  const std::size_t rows = different.size();
  std::ranges::sort(different);
  different.erase(std::ranges::unique(different).begin(), different.end());
  for (std::size_t i = 1; i < different.size(); ++i)
    if (different[i] - different[i - 1] < kBeside * step) return false;
  return kFewestVisits * different.size() <= rows;
}

// The coarsest first. A motor's reading may be what was measured, or the pose behind it.
std::vector<Step> steps_of(const Problem& problem, const ProblemOutput& output,
                           const Dataset& given) {
  const auto* column = given.find(output.channel.symbol);
  if (column == nullptr) return {};
  std::vector<Step> steps;
  const double own = decimal_step(column->values);
  if (!are_set(column->values, own)) {
    const auto read = coordinates_read(problem, given);
    steps.push_back({column->channel.name(), own * summary_unit(column->channel.unit).factor,
                     !read.empty() && std::ranges::all_of(read, [&](const DatasetColumn* set) {
                       return go_in_steps_of(*column, own, *set);
                     })});
  }
  if (is_motor_symbol(output.channel.symbol))
    steps.push_back(step_behind_motor(problem, output, given));
  std::erase_if(steps, [](const Step& step) { return !(step.size > 0); });
  std::ranges::sort(steps, std::ranges::greater{}, &Step::size);
  return steps;
}

// Rounding errors are uniform over a step, whatever lies behind them (Kolmogorov's test). Nominal
// values do not fill it, nor does what is left of an effect that is not found yet. Rows that are
// foretold within a step count as one. Not asked where what is set goes in whole steps itself: what
// is measured never does.
bool fill_the_step(const Law& law, const Eigen::VectorXd& readings, double step) {
  std::vector<double> foretold(law.foretold.data(), law.foretold.data() + law.foretold.size());
  std::ranges::sort(foretold);
  double places = 1, from = foretold.front();
  for (const double one : foretold)
    if (one - from > kSamePlace * step) from = one, ++places;
  std::vector<double> off;  // from the middle of the step, 0 to 1
  for (Eigen::Index i = 0; i < readings.size(); ++i) {
    const double u = (readings[i] - law.foretold[i]) / step;
    off.push_back(2 * std::abs(u - std::round(u)));
  }
  std::ranges::sort(off);
  double farthest = 0;
  const auto count = static_cast<double>(off.size());
  for (std::size_t i = 0; i < off.size(); ++i)
    farthest = std::max({farthest, off[i] - static_cast<double>(i) / count,
                         static_cast<double>(i + 1) / count - off[i]});
  return farthest < kKolmogorovAt1 / std::sqrt(places);
}

struct Rounding {
  Step step;
  Law law;
};

// The first of them that is no nominal position's and that the noise does not hide.
std::optional<Rounding> rounding_of(const std::vector<Step>& steps,
                                    const Eigen::MatrixXd& simulation,
                                    const Eigen::VectorXd& readings, double most_noise) {
  for (const Step& step : steps) {
    auto law = behind(simulation, readings, step.size);
    if (!law) return std::nullopt;
    const double spread = spread_about(law->foretold, readings, step.size);
    if (step.is_grid ? spread < kLeastSpread : !fill_the_step(*law, readings, step.size)) continue;
    if (spread > kMostSpread || law->sd > most_noise * step.size) return std::nullopt;
    return Rounding{step, std::move(*law)};
  }
  return std::nullopt;
}

// A wave of the step, or of a whole part of it: the rounding errors' own Fourier series.
bool spells_out_a_step(const Finding& finding, const std::vector<Step>& steps) {
  constexpr double kNearAWhole = 1e-3;
  return finding.cause == "cyclic_error" &&
         std::ranges::any_of(finding.parameters, [&](const FoundParameter& parameter) {
           return std::ranges::any_of(steps, [&](const Step& step) {
             const double parts = step.size / parameter.value, whole = std::round(parts);
             return whole >= 1 && std::abs(parts - whole) < kNearAWhole * whole;
           });
         });
}

}  // namespace

double decimal_step(const std::vector<double>& values) {
  double low = INFINITY, high = -INFINITY;
  std::size_t count = 0;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    low = std::min(low, value), high = std::max(high, value);
    ++count;
  }
  if (count < kFewestRounded || !(high > low)) return 0;
  const double largest = std::max(std::abs(low), std::abs(high));
  const auto is_step = [&](double step) {
    const double off = std::max(kOffTheGrid, 1e-14 * largest / step);
    return std::ranges::all_of(values, [&](double value) {
      return !std::isfinite(value) || std::abs(value / step - std::round(value / step)) < off;
    });
  };
  for (double power = std::pow(10, std::ceil(std::log10(high - low)));
       power > kSmallest * (high - low); power /= 10)
    for (const double digit : {5.0, 2.0, 1.0})
      if (const double step = digit * power; step <= high - low && is_step(step)) return step;
  return 0;
}

Result<std::vector<std::string>> free_of_rounding(Problem& problem, const Dataset& given,
                                                  const std::vector<Finding>& found) {
  std::vector<std::string> said;
  std::vector<std::size_t> rows = problem.learn;
  rows.insert(rows.end(), problem.judge.begin(), problem.judge.end());
  std::ranges::sort(rows);
  rows.erase(std::ranges::unique(rows).begin(), rows.end());
  std::vector<Eigen::VectorXd> freed(problem.outputs.size());
  for (std::size_t o = 0; o < problem.outputs.size(); ++o) {
    auto& output = problem.outputs[o];
    const auto steps = steps_of(problem, output, given);
    if (steps.empty()) continue;
    Eigen::MatrixXd simulation = problem.base_columns;
    for (const auto& finding : found) {
      if (finding.terms.empty() || spells_out_a_step(finding, steps)) continue;
      DRIFTWISE_TRY(const auto columns, problem.prepared.columns(finding.terms));
      if (!rows_of(columns, rows).allFinite()) continue;
      const Eigen::MatrixXd before = simulation;
      simulation.resize(before.rows(), before.cols() + columns.cols());
      simulation << before, columns;
    }
    Eigen::MatrixXd x = rows_of(simulation, rows);
    const Eigen::RowVectorXd lengths = x.colwise().norm().cwiseMax(1e-300);
    x = (x.array().rowwise() / lengths.array()).matrix().eval();
    const Eigen::VectorXd readings = rows_of(output.measured, rows);
    const auto rounding =
        rounding_of(steps, x, readings, found.empty() ? kNoiseAlone : kNoiseOfAStep);
    if (!rounding) continue;
    const auto& [read, law] = *rounding;
    const double step = read.size;
    std::mt19937_64 random(1);
    freed[o] = Eigen::VectorXd::Zero(output.measured.size());
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(i);
      const double value =
          law.foretold[at] + law.sd * drawn((readings[at] - step / 2 - law.foretold[at]) / law.sd,
                                            (readings[at] + step / 2 - law.foretold[at]) / law.sd,
                                            random);
      freed[o][static_cast<Eigen::Index>(rows[i])] = readings[at] - value;
    }
    said.push_back(read.channel + " is read in steps of " + quantity_text(step, output.unit) +
                   ", and its noise is " + quantity_text(law.sd, output.unit) +
                   ": where in a step a value was is taken from the simulation and this noise. An "
                   "effect of less than a step is hardly seen; a finer display would show it");
  }
  if (said.empty()) return said;
  for (std::size_t o = 0; o < problem.outputs.size(); ++o) {
    auto& output = problem.outputs[o];
    if (freed[o].size() == 0) freed[o] = Eigen::VectorXd::Zero(output.measured.size());
    output.freed_of = freed[o];
    output.measured -= freed[o];
  }
  return said;
}

}  // namespace driftwise::diagnosis
