// What the cell declares, put into the model's own coefficients: each declared error of a channel
// moved the fit, and its influence says by how much.

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <map>

#include "server/compensation/declared_errors.h"
#include "server/compensation/own_variance.h"
#include "server/compensation/snapshot_builder.h"
#include "server/effects/term_order.h"

namespace driftwise::compensation {
namespace {

std::string symbol_of(const std::string& full_name) {
  return full_name.substr(0, full_name.rfind('_'));
}
std::string unit_of(const std::string& full_name) {
  const auto underscore = full_name.rfind('_');
  return underscore == std::string::npos ? "" : full_name.substr(underscore + 1);
}

// How many of its own units a channel errs by for an error of 1 in the summary unit; and how many
// mm or arcsec one unit of what the error goes with is.
double own_units(const std::string& full_name) {
  return 1 / summary_unit(unit_of(full_name)).factor;
}
double base_units(const std::string& by) {
  const std::string unit = unit_of(by);
  if (is_length(unit)) return mm_from_nm(summary_unit(unit).factor);
  return is_angle(unit) ? summary_unit(unit).factor : 1.0;
}

// Without the constants of other data, which are not served.
Eigen::VectorXd served(const Eigen::VectorXd& shift, const std::vector<effects::Term>& terms) {
  std::vector<Eigen::Index> kept;
  for (std::size_t k = 0; k < terms.size(); ++k)
    if (!effects::datum_of(terms[k])) kept.push_back(static_cast<Eigen::Index>(k));
  return shift(kept);
}

bool is_of(const DeclaredError& error, const calibration::Influence& influence) {
  return error.symbol == symbol_of(influence.channel) &&
         error.by ==
             (influence.by.find('_') == std::string::npos ? influence.by : symbol_of(influence.by));
}

// In the units of the influence.
double size_of(const DeclaredError& error, const calibration::Influence& influence) {
  return error.u * own_units(influence.channel) * base_units(influence.by);
}

const calibration::Influence* influence_of(const calibration::OutputModel& output,
                                           const std::string& channel, const std::string& by) {
  const auto found = std::ranges::find_if(
      output.influences, [&](const auto& one) { return one.channel == channel && one.by == by; });
  return found == output.influences.end() ? nullptr : &*found;
}

// R with R R' = W W' - sum over the errors of v v': W (1 - O O')^1/2 where W O = the errors. Every
// v is a covariance with an error of size 1, so that nothing negative is left but by rounding.
Eigen::MatrixXd root_without(const Eigen::MatrixXd& root,
                             const std::vector<const Eigen::VectorXd*>& errors) {
  using WideMatrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
  // Terms of all sizes, each with its own digits.
  Eigen::VectorXd size = root.rowwise().norm();
  for (double& one : size)
    if (!(one > 0)) one = 1;
  const WideMatrix scaled = (size.cwiseInverse().asDiagonal() * root).cast<long double>();
  WideMatrix of_errors(root.rows(), static_cast<Eigen::Index>(errors.size()));
  for (std::size_t e = 0; e < errors.size(); ++e)
    of_errors.col(static_cast<Eigen::Index>(e)) =
        errors[e]->cwiseQuotient(size).cast<long double>();
  const Eigen::MatrixXd part =
      scaled.completeOrthogonalDecomposition().solve(of_errors).cast<double>();
  const Eigen::MatrixXd left =
      Eigen::MatrixXd::Identity(root.cols(), root.cols()) - part * part.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(left);
  return root * eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal();
}

}  // namespace

double nm_per_unit(const Channel& output) {
  return summary_unit(output.unit).factor * (is_angle(output.unit) ? kNmPerMm : 1.0);
}

double instrument_noise_nm2(const calibration::OutputModel& output, const CellDescription& cell,
                            const MeasuredCoordinates& measured_by) {
  // Of what read the output: the motor's scale or, of a predicted motion, the instrument of that
  // coordinate.
  double noise_nm2 = std::pow(reading_noise(cell, output.channel.symbol, measured_by) *
                                  own_units(output.channel.name()) * nm_per_unit(output.channel),
                              2);
  for (const auto& influence : output.influences) {
    const std::string symbol = symbol_of(influence.channel);
    if (influence.by == "1" && is_pose_symbol(symbol))
      noise_nm2 +=
          std::pow(reading_noise(cell, symbol, measured_by) * own_units(influence.channel) *
                       influence.rms * nm_per_unit(output.channel),
                   2);
  }
  return noise_nm2;
}

std::uint32_t SnapshotBuilder::number_of(const std::string& error) {
  return numbers_.try_emplace(error, static_cast<std::uint32_t>(numbers_.size())).first->second;
}

// The geometry's part of an error that the terms have in every output: once, with the first.
void SnapshotBuilder::add_parameter_error(const std::string& channel, const std::string& by,
                                          double size, const Systematic& of_terms) {
  if (!model_.geometry) return;
  for (const auto& influence : model_.geometry->influences) {
    if (influence.channel != channel || influence.by != by) continue;
    const Eigen::VectorXd shift = influence.shift * size;
    auto same = std::ranges::find_if(parameter_errors_, [&](const auto& one) {
      return one.source == of_terms.source && one.number == of_terms.number;
    });
    if (same == parameter_errors_.end())
      same = parameter_errors_.insert(
          same, {of_terms.source, of_terms.number, of_terms.shared_with_zero,
                 std::vector<double>(static_cast<std::size_t>(shift.size()), 0.0)});
    for (std::size_t k = 0; k < same->shift.size(); ++k)
      same->shift[k] += shift[static_cast<Eigen::Index>(k)];
  }
}

// Of an arm the instruments measured the pose, which its parameters give: their errors are in those
// alone. Every joint has a line of each, without terms.
void SnapshotBuilder::add_errors_of_arm(const CellDescription& cell) {
  for (const auto& influence : model_.geometry->influences)
    for (const auto& error : declared_errors(cell, model_.lineage.measured_by)) {
      if (!is_of(error, influence)) continue;
      Systematic one{error.source, Eigen::VectorXd(), error.shared_with_zero};
      one.number = number_of(error.cause.empty() ? error.symbol + " by " + error.by : error.cause);
      const std::size_t known = parameter_errors_.size();
      add_parameter_error(influence.channel, influence.by, size_of(error, influence), one);
      if (parameter_errors_.size() == known) continue;
      for (auto& output : outputs_) output.systematics.push_back(one);
    }
}

void SnapshotBuilder::add_uncertainty(const calibration::OutputModel& from,
                                      const CellDescription& cell, Output& output) {
  const auto declared = declared_errors(cell, model_.lineage.measured_by);
  // No scale reads a coordinate of the pose.
  if (gives_ == Gives::motors)
    output.u_scale_nm = reading_noise(cell, output.channel.symbol, model_.lineage.measured_by);
  output.absorbed.resize(slow_.channels().size());
  // Of one source and one cause: drifts with the hours or with one thermometer, what one rotation's
  // error does to all lengths.
  std::map<std::pair<UncertaintySource, std::string>, Systematic> of_cause;
  for (const auto& influence : from.influences) {
    const std::string symbol = symbol_of(influence.channel);
    for (const auto& error : declared) {
      if (!is_of(error, influence)) continue;
      const double size = size_of(error, influence);
      Systematic one{error.source, served(influence.shift, from.terms) * size,
                     error.shared_with_zero};
      if (const auto* kept = influence_of(from, influence.channel, "zero");
          error.is_reading_at_zero && kept != nullptr)
        one.in_rows = served(kept->shift, from.terms) * size;
      one.number = number_of(error.cause.empty() ? error.symbol + " by " + error.by : error.cause);
      if (&from == &model_.outputs.front())
        add_parameter_error(influence.channel, influence.by, size, one);
      if (error.cause.empty()) {
        output.systematics.push_back(std::move(one));
        continue;
      }
      // One error: with their signs, before squaring.
      const auto [all, is_first] = of_cause.try_emplace({error.source, error.cause}, one);
      if (is_first) continue;
      all->second.shift += one.shift;
      if (all->second.in_rows.size() == 0)
        all->second.in_rows = one.in_rows;
      else if (one.in_rows.size() > 0)
        all->second.in_rows += one.in_rows;
    }
    if (influence.by != "1") continue;
    if (const auto slow = slow_.find(symbol))
      output.absorbed[*slow] = served(influence.shift, from.terms);
  }
  for (auto& [cause, error] : of_cause) output.systematics.push_back(std::move(error));
}

// What a residual holds beyond the noise of the instruments that saw it is the robot's own. Lengths
// among themselves and rotations among themselves are alike.
void SnapshotBuilder::add_own_scatter(const CellDescription& cell) {
  for (const bool angles : {false, true}) {
    std::vector<Output*> alike;
    std::vector<const calibration::OutputModel*> fitted;
    std::vector<Scatter> scatter;
    for (auto& output : outputs_)
      for (const auto& from : model_.outputs) {
        if (from.channel.symbol != output.channel.symbol || is_angle(from.channel.unit) != angles)
          continue;
        const double residual_nm = from.accuracy.rmse * nm_per_unit(from.channel);
        alike.push_back(&output);
        fitted.push_back(&from);
        scatter.push_back({residual_nm * residual_nm,
                           instrument_noise_nm2(from, cell, model_.lineage.measured_by),
                           variance_dof(from)});
      }
    const auto own_nm2 = own_variances(scatter);
    for (std::size_t i = 0; i < alike.size(); ++i) {
      alike[i]->unfollowed_nm = std::sqrt(own_nm2[i]);
      share_noise(*fitted[i], scatter[i].noise2, *alike[i]);
    }
  }
}

// Of the rows' noise the instruments have what the robot's own scatter leaves, and not more than
// they are declared to have. Their correlation with the zero's reading is that share of the noise.
void SnapshotBuilder::share_noise(const calibration::OutputModel& from, double noise_nm2,
                                  Output& output) {
  const double unit_nm2 = std::pow(nm_per_unit(from.channel), 2);
  const double all_nm2 = from.noise_variance * unit_nm2,
               residual_nm2 = std::pow(from.accuracy.rmse, 2) * unit_nm2;
  if (!(all_nm2 > 0) || !(residual_nm2 > 0) || !(noise_nm2 > 0)) {
    for (auto& error : output.systematics) error.in_rows.resize(0);
    return;
  }
  const double own = std::min(1.0, std::pow(output.unfollowed_nm, 2) / residual_nm2);
  const double instruments_nm2 = std::min(noise_nm2, all_nm2 * (1 - own));
  std::vector<const Eigen::VectorXd*> in_rows;
  for (auto& error : output.systematics) {
    error.in_rows *= instruments_nm2 / noise_nm2;
    if (error.in_rows.size() > 0) in_rows.push_back(&error.in_rows);
  }
  if (!in_rows.empty() && output.root.size() > 0)
    output.root_beside_zero = root_without(output.root, in_rows);
}

}  // namespace driftwise::compensation
