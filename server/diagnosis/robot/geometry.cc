#include "server/diagnosis/robot/geometry.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string_view>

#include "server/core/text/quantity_text.h"
#include "server/core/try.h"
#include "server/core/units.h"
#include "server/diagnosis/answer/cancelled.h"
#include "server/diagnosis/answer/u90.h"
#include "server/diagnosis/robot/parameter_selection.h"
#include "server/diagnosis/robot/whitened_geometry.h"
#include "server/diagnosis/rows/held_out_gain.h"

namespace driftwise::diagnosis {
namespace {

using Eigen::Index;
using identification::Identification;

// "link2.alpha_deg": subject and unit.
std::pair<std::string, std::string> name_and_unit(const std::string& parameter) {
  const auto at = parameter.rfind('_');
  return {parameter.substr(0, at), parameter.substr(at + 1)};
}

Result<Identification> identify_with(const Dataset& data,
                                     std::shared_ptr<const kinematics::Mechanism> mechanism,
                                     const std::vector<effects::Term>& terms, bool placement_only) {
  identification::IdentifyOptions options;
  options.mechanism = std::move(mechanism);
  options.terms = terms;
  options.placement_only = placement_only;
  return identification::identify(data, options);
}

// The same drawing with everything held but where it stands and what was named.
Result<std::shared_ptr<const kinematics::Mechanism>> holding_others(
    const kinematics::Mechanism& mechanism, const std::vector<std::size_t>& named) {
  KinematicsDescription description = mechanism.description();
  for (std::size_t k = 0; k < mechanism.parameters().size(); ++k) {
    const auto& parameter = mechanism.parameters()[k];
    if (!parameter.placement && std::ranges::find(named, k) == named.end())
      description.hold.push_back(parameter.name);
  }
  return kinematics::make_mechanism(description);
}

std::string sentence_of(const Finding& finding, double nominal, const std::string& unit) {
  const auto& value = finding.parameters.front();
  char text[160];
  std::snprintf(text, sizeof text, "%s is %.7g %s (90 %%: %.7g to %.7g), not %.7g as drawn",
                finding.subject.c_str(), value.value, unit.c_str(), value.ci90->low,
                value.ci90->high, nominal);
  std::string all = text;
  for (const auto& output : finding.outputs) {
    const double before = output.a90_before.value_or(0), after = output.a90_after.value_or(0);
    const SizeUnit shown = size_unit({output.amplitude, before, after}, output.unit);
    all += "; " + output.output + ": " + digits_text(output.amplitude * shown.factor) + " " +
           shown.unit + " rms";
    if (output.a90_before)
      all += ", held-out A90 " + digits_text(before * shown.factor) + " -> " +
             digits_text(after * shown.factor) + " " + shown.unit;
  }
  all += ".";
  for (std::size_t i = 0; i < finding.indistinguishable_from.size(); ++i)
    all += (i == 0 ? " These data cannot tell it from " : ", ") + finding.indistinguishable_from[i];
  return finding.indistinguishable_from.empty() ? all : all + ".";
}

class Geometry {
 public:
  // white: of the same rows, as if the noise of none hung together with the next.
  Geometry(const Problem& problem, const Identification& identified, WhitenedGeometry whole,
           const WhitenedGeometry& white, double alpha)
      : problem_(problem),
        identified_(identified),
        whole_(std::move(whole)),
        selection_({{whole_.columns, whole_.y}, {white.columns, white.y}}, roles()) {
    do selection_.select(alpha);
    while (withdraw_what_harms());
  }

  const std::vector<std::size_t>& named() const { return selection_.chosen(); }
  Finding finding(std::size_t k) const {
    const auto at = static_cast<Index>(k);
    const auto& parameter = identified_.parameters[k].parameter;
    const auto [subject, unit] = name_and_unit(parameter.name);
    const double deviation = selection_.coefficients()[at];
    const double reach = kSigmaToU90 * selection_.standard_errors()[at];
    const double value = parameter.nominal + deviation;
    Finding found{.cause = "geometry_parameter", .subject = subject, .where = "robot"};
    found.parameters.push_back(
        {"value_" + unit, value, Interval{value - reach, value + reach}, {}});
    found.parameters.push_back(
        {"deviation_" + unit, deviation, Interval{deviation - reach, deviation + reach}, {}});
    found.p_adjusted = selection_.adjusted_p(k);
    found.log_likelihood_ratio = selection_.gain_2lnl(k) / 2;
    for (const std::size_t rival : selection_.rivals(k))
      found.indistinguishable_from.push_back(
          "geometry_parameter " +
          name_and_unit(identified_.parameters[rival].parameter.name).first);
    add_outputs(k, deviation, found);
    found.sentence = sentence_of(found, parameter.nominal, unit);
    return found;
  }

 private:
  // Where the robot stands and what is linear is in; what the full identification held looks like
  // others and stays out.
  std::vector<ParameterSelection::Role> roles() const {
    using Role = ParameterSelection::Role;
    std::vector<Role> roles(static_cast<std::size_t>(whole_.columns.cols()), Role::always_in);
    for (std::size_t k = 0; k < identified_.parameters.size(); ++k) {
      const auto& one = identified_.parameters[k];
      if (!one.free) roles[k] = Role::left_out;
      if (one.free && !one.parameter.placement) roles[k] = Role::offered;
    }
    return roles;
  }

  // The one whose going mends most where judging rows are described worse with it, over all outputs
  // together: a number moves them all. Else the weakest, where any output is worse with all of them
  // than with none. Was there one?
  bool withdraw_what_harms() {
    if (named().empty()) return false;
    const auto left = [this](const Eigen::VectorXd& coefficients) {
      return Eigen::VectorXd(whole_.y_raw_judge - whole_.raw_judge * coefficients);
    };
    const std::size_t rows = problem_.judge.size();
    const Eigen::VectorXd with = left(selection_.coefficients());
    std::size_t goes = ParameterSelection::kNone;
    double most = 0;
    for (const std::size_t k : named()) {
      const auto one = held_out_ratio_together(left(selection_.coefficients(k)), with, rows);
      if (one.is_worse() && one.ratio() > most) most = one.ratio(), goes = k;
    }
    if (goes == ParameterSelection::kNone) {
      if (harm(left(selection_.coefficients_of_none()), with, rows) == 0) return false;
      goes = *std::ranges::min_element(named(), {},
                                       [this](std::size_t k) { return selection_.gain_2lnl(k); });
    }
    selection_.forbid(goes);
    return true;
  }

  void add_outputs(std::size_t k, double deviation, Finding& found) const {
    Eigen::MatrixXd others = whole_.raw, white = whole_.columns;
    for (Index j = 0; j < others.cols(); ++j) {
      const auto column = static_cast<std::size_t>(j);
      if (column != k && selection_.is_in(column)) continue;
      others.col(j).setZero();
      white.col(j).setZero();
    }
    const auto beyond = [](const Eigen::MatrixXd& base, const Eigen::VectorXd& column) {
      return Eigen::VectorXd(column - base * base.colPivHouseholderQr().solve(column));
    };
    const auto at = static_cast<Index>(k);
    const Eigen::VectorXd raw = deviation * beyond(others, whole_.raw.col(at));
    const Eigen::VectorXd evidence = deviation * beyond(white, whole_.columns.col(at));
    const Eigen::VectorXd before =
        whole_.y_raw_judge - whole_.raw_judge * selection_.coefficients(k);
    const Eigen::VectorXd after = whole_.y_raw_judge - whole_.raw_judge * selection_.coefficients();
    found.outputs = outputs_moved(problem_, raw, before, after);
    const auto n = static_cast<Index>(problem_.learn.size());
    for (std::size_t o = 0; o < found.outputs.size(); ++o)
      found.outputs[o].gain_2lnl = evidence.segment(static_cast<Index>(o) * n, n).squaredNorm();
  }

  const Problem& problem_;
  const Identification& identified_;
  WhitenedGeometry whole_;
  ParameterSelection selection_;
};

constexpr std::string_view kCause = "geometry_parameter ";

}  // namespace

Dataset marked_rows(Dataset data, const Problem& problem) {
  data.set.assign(data.rows, PointSet::calibration);
  data.excluded.assign(data.rows, 1);
  for (const std::size_t row : problem.learn) data.excluded[row] = 0;
  for (const std::size_t row : problem.judge) {
    data.excluded[row] = 0;
    data.set[row] = PointSet::validation;
  }
  return data;
}

Result<GeometryDiagnosis> diagnose_geometry(
    const Dataset& dataset, const Problem& problem,
    const std::shared_ptr<const kinematics::Mechanism>& mechanism,
    const std::vector<effects::Term>& terms, double alpha, const std::function<bool()>& tick) {
  const Dataset data = marked_rows(dataset, problem);
  DRIFTWISE_TRY(auto nominal, identify_with(data, mechanism, terms, true));
  DRIFTWISE_TRY(const auto identified, identify_with(data, mechanism, terms, false));
  if (tick && !tick()) return cancelled();
  auto whole = whitened_geometry(data, problem, identified, noise_grid(problem.timeline), tick);
  auto white = whitened_geometry(data, problem, identified, {NoiseShape{}}, tick);
  if (!whole || !white) return cancelled();
  const Geometry geometry(problem, identified, std::move(*whole), *white, alpha);
  GeometryDiagnosis result{{}, {}, std::move(nominal), {}};
  for (const std::size_t k : geometry.named()) result.findings.push_back(geometry.finding(k));
  std::ranges::stable_sort(result.findings, std::ranges::greater{}, &Finding::log_likelihood_ratio);
  for (const auto& one : identified.parameters)
    if (!one.free && !one.parameter.placement)
      result.held.push_back({std::string(kCause) + one.parameter.name, one.note});
  DRIFTWISE_TRY(const auto extended, holding_others(*mechanism, geometry.named()));
  DRIFTWISE_TRY(auto fitted, identify_with(data, extended, terms, false));
  result.extended = std::move(fitted);
  return result;
}

}  // namespace driftwise::diagnosis
