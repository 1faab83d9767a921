#include "server/diagnosis/report/motor_figures.h"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "server/core/units.h"
#include "server/diagnosis/catalogue/linear_parameter.h"
#include "server/diagnosis/growth/motors_as_served.h"
#include "server/diagnosis/report/sentence.h"
#include "server/diagnosis/rows/held_out_gain.h"

namespace driftwise::diagnosis {
namespace {

using Index = Eigen::Index;

// Coefficients of the finding's terms on the coordinates, terms x coordinates in summary units; 0
// where it does not act.
Eigen::MatrixXd on_coordinates(const Problem& problem, const Named& named, const Finding& finding) {
  Eigen::MatrixXd result =
      Eigen::MatrixXd::Zero(named.all.cols(), static_cast<Index>(problem.outputs.size()));
  const bool anywhere = std::ranges::any_of(named.share, [](double share) { return share > 0; });
  for (std::size_t c = 0; c < problem.outputs.size(); ++c) {
    if (anywhere && named.share[c] == 0) continue;
    const auto& output = problem.outputs[c];
    const auto at =
        std::ranges::find(finding.outputs, output.channel.symbol, &FindingOutput::output);
    if (at == finding.outputs.end()) continue;
    for (std::size_t k = 0; k < at->coefficients.size(); ++k)
      result(static_cast<Index>(k), static_cast<Index>(c)) = at->coefficients[k] * output.factor;
  }
  return result;
}

// Whose error is spread over the coordinates as `sizes` is: a coordinate, whose error is in itself
// alone, or a motor, whose error is in all of them. sizes: in units of the noise.
std::string subject_in_frame(const CoordinateFrame& frame, const Problem& problem,
                             const Eigen::VectorXd& sizes, const Eigen::VectorXd& noise_sd,
                             bool may_be_motor) {
  const auto size = static_cast<Index>(problem.outputs.size());
  Index own = 0;
  double most = sizes.cwiseAbs().maxCoeff(&own) / sizes.norm();
  std::string found = problem.outputs[static_cast<std::size_t>(own)].channel.symbol;
  if (!may_be_motor) return found;
  Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(size, size);
  for (const std::size_t row : problem.learn) mean += frame.turn[row];
  const Eigen::MatrixXd of_motors =
      noise_sd.cwiseInverse().asDiagonal() * Eigen::MatrixXd(mean.inverse());
  for (Index o = 0; o < size; ++o) {
    const double alike =
        std::abs(of_motors.col(o).dot(sizes)) / (of_motors.col(o).norm() * sizes.norm());
    if (!(alike > most)) continue;
    most = alike;
    found = frame.motors[static_cast<std::size_t>(o)].channel.symbol;
  }
  return found;
}

// Uncertainties of a motor's correction: those of the coordinates through its slopes.
void turn_corrections(const CoordinateFrame& frame, const Problem& problem, const Finding& finding,
                      std::vector<FindingOutput>& motors) {
  const auto size = static_cast<Index>(motors.size());
  Eigen::MatrixXd squares = Eigen::MatrixXd::Zero(size, size);
  for (const std::size_t row : problem.learn) squares += frame.turn[row].cwiseAbs2();
  squares /= static_cast<double>(problem.learn.size());
  Eigen::VectorXd rms = Eigen::VectorXd::Zero(size), u90 = rms;
  bool any = false;
  for (Index c = 0; c < size; ++c) {
    const auto at = std::ranges::find(finding.outputs,
                                      problem.outputs[static_cast<std::size_t>(c)].channel.symbol,
                                      &FindingOutput::output);
    if (at == finding.outputs.end() || !at->shown || !at->correction_u90) continue;
    any = true;
    rms += squares.col(c) * std::pow(at->correction_rms.value_or(0), 2);
    u90 += squares.col(c) * std::pow(*at->correction_u90, 2);
  }
  for (Index o = 0; any && o < size; ++o) {
    motors[static_cast<std::size_t>(o)].correction_rms = std::sqrt(rms[o]);
    motors[static_cast<std::size_t>(o)].correction_u90 = std::sqrt(u90[o]);
  }
}

// The number of a motor's own error (the width of its play) is the motor's: a coordinate has a part
// of it. Its error by the evidence for the whole. coefficients: of the motor, summary units.
void say_own_number(const Cause& cause, const Named& named, const ProblemOutput& motor,
                    const Eigen::VectorXd& coefficients, Finding& finding) {
  const bool of_angle = motor.unit == "arcsec";
  const std::size_t of_one_value = named.values.front().terms.size();
  const double errors = std::sqrt(std::max(2 * finding.log_likelihood_ratio, 1.0));
  for (std::size_t k = 0; k < named.terms.size(); ++k) {
    const double at = named.values[k / of_one_value].parameter;
    const auto number = of_angle ? linear_number_of_angle(cause.linear, named.terms[k], at)
                                 : linear_number(cause.linear, named.terms[k], at);
    if (number.name.empty()) continue;
    if (k == 0)
      std::erase_if(finding.parameters, [&](const FoundParameter& one) {
        return one.curve.empty() && one.name.find(number.name) != std::string::npos;
      });
    double value = coefficients[static_cast<Index>(k)] * number.factor;
    if (number.name.starts_with("width")) value = std::abs(value);
    const double reach = kSigmaToU90 * std::abs(value) / errors;
    finding.parameters.push_back({k == 0 ? number.name : number.name + "_" + std::to_string(k + 1),
                                  value,
                                  Interval{value - reach, value + reach},
                                  {}});
  }
}

}  // namespace

void say_of_motors(const CoordinateFrame& frame, const Problem& problem, const Cause& cause,
                   const Extension& extension, std::size_t index, Finding& finding) {
  const Named& named = extension.named()[index];
  const auto size = static_cast<Index>(problem.outputs.size());
  const Eigen::MatrixXd coefficients = on_coordinates(problem, named, finding);
  const Eigen::MatrixXd columns = rows_of(named.all, problem.learn),
                        base = rows_of(problem.base_columns, problem.learn);
  const Eigen::MatrixXd added = frame.of_motors(columns * coefficients, problem.learn);
  Eigen::MatrixXd both(base.rows(), base.cols() + columns.cols());
  both << base, columns;
  const Eigen::RowVectorXd scale = both.colwise().norm().cwiseMax(1e-300).cwiseInverse();
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(both * scale.asDiagonal());
  const Eigen::MatrixXd fitted = scale.asDiagonal() * qr.solve(added);
  const Eigen::MatrixXd own = columns * fitted.bottomRows(columns.cols());
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> of_base(base);
  const Eigen::MatrixXd beyond = own - base * of_base.solve(own);
  const auto judges = static_cast<Index>(problem.judge.size());
  Eigen::MatrixXd before, after;
  if (judges >= 4) {
    before = judged_motors_as_served(frame, problem, extension, index);
    after = judged_motors_as_served(frame, problem, extension);
  }
  const Eigen::MatrixXd left = motors_as_served(
      frame, problem, extension, problem.learn,
      [&problem](const ProblemOutput& coordinate, const SoftBase& simulation) -> Eigen::VectorXd {
        return rows_of(residuals(problem, coordinate, simulation), problem.learn);
      });
  std::vector<FindingOutput> outputs;
  std::vector<double> seen;
  for (Index o = 0; o < size; ++o) {
    const ProblemOutput& motor = frame.motors[static_cast<std::size_t>(o)];
    if (!extension.is_said_of(index, motor.channel.symbol)) continue;
    FindingOutput one{.output = motor.channel.symbol, .unit = motor.unit};
    one.amplitude = std::sqrt(beyond.col(o).squaredNorm() / static_cast<double>(beyond.rows()));
    const double rest = left.col(o).squaredNorm();
    one.gain_2lnl = static_cast<double>(left.rows()) *
                    std::log((rest + beyond.col(o).squaredNorm()) / std::max(rest, 1e-300));
    seen.push_back(beyond.col(o).norm() / std::sqrt(std::max(rest, 1e-300)));
    for (Index k = 0; k < columns.cols(); ++k)
      one.coefficients.push_back(fitted(base.cols() + k, o) / motor.factor);
    if (judges >= 4) {
      const auto held = held_out(before.col(o), after.col(o));
      one.judge(held.before, held.after);
      one.u90_after_ci90 = held.u90_after_ci90;
      one.a90_after_ci90 = held.a90_after_ci90;
    }
    outputs.push_back(std::move(one));
  }
  for (std::size_t k = 0; k < outputs.size(); ++k)
    outputs[k].shown = seen[k] > kShownShare * std::ranges::max(seen);
  for (std::size_t o = 0; o < frame.motors.size(); ++o)
    if (frame.motors[o].channel.symbol == cause.subject && outputs.size() == 1)
      say_own_number(cause, named, frame.motors[o],
                     fitted.bottomRows(columns.cols()).col(static_cast<Index>(o)), finding);
  if (outputs.size() == frame.motors.size()) turn_corrections(frame, problem, finding, outputs);
  if (cause.subject.empty() && finding.applies_to != effects::AppliesTo::robot) {
    Eigen::VectorXd noise_sd(size);
    for (Index c = 0; c < size; ++c)
      noise_sd[c] = extension.between_neighbours(static_cast<std::size_t>(c));
    // Of two phases the stronger one.
    const Eigen::MatrixXd centred = columns.rowwise() - columns.colwise().mean();
    const Eigen::MatrixXd in_noise =
        centred.colwise().norm().asDiagonal() * coefficients * noise_sd.cwiseInverse().asDiagonal();
    Index strongest = 0;
    in_noise.rowwise().norm().maxCoeff(&strongest);
    const Eigen::VectorXd sizes = in_noise.row(strongest).transpose();
    finding.subject = subject_in_frame(frame, problem, sizes, noise_sd,
                                       finding.applies_to == effects::AppliesTo::dataset);
  }
  finding.outputs = std::move(outputs);
  finding.sentence = sentence(finding);
}

}  // namespace driftwise::diagnosis
