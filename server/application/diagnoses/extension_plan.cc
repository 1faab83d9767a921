#include "server/application/diagnoses/extension_plan.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <map>

#include "server/application/diagnoses/instrument_agreement.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/core/units.h"
#include "server/correction/first_conditions.h"
#include "server/effects/effect.h"
#include "server/effects/term_order.h"
#include "server/formats/diagnosis/robot_names.h"
#include "server/formats/formula/formula.h"
#include "server/simulation/motor_slopes.h"

namespace driftwise::application {
namespace {

bool reads_data_time(const std::vector<effects::Term>& terms) {
  for (const auto& term : terms)
    for (const auto& factor : term.factors)
      if (const auto* call = std::get_if<effects::Call>(&factor))
        if (const auto* kind = effects::find_effect(call->effect); kind && kind->in_data_time)
          return true;
  return false;
}

std::vector<RunId> runs_in(const RunsData& data) {
  std::vector<RunId> runs;
  for (const auto& origin : data.origins)
    if (std::ranges::find(runs, origin.run) == runs.end()) runs.push_back(origin.run);
  return runs;
}

class Planner {
 public:
  Planner(DiagnosisId id, const diagnosis::Diagnosis& found, const RunsData& data)
      : id_(id), found_(found), data_(data) {
    plan_.formula = found.baseline_formula;
  }

  Result<ExtensionPlan> plan(const std::vector<int>& chosen) {
    plan_.findings = chosen;
    for (const int number : chosen) {
      const auto& finding = found_.findings[static_cast<std::size_t>(number - 1)];
      DRIFTWISE_RETURN_IF_ERROR(add(number, finding));
    }
    for (auto& [run, rows] : rows_out_) {
      std::ranges::sort(rows);
      const auto again = std::ranges::unique(rows);
      rows.erase(again.begin(), again.end());
      plan_.exclusions.push_back({0,
                                  run,
                                  true,
                                  rows,
                                  fmt::format("diagnosis {}: {}", id_.value, reason_of_[run]),
                                  {},
                                  "",
                                  ""});
    }
    if (!plan_.extends_model && plan_.amendment.empty() && plan_.exclusions.empty())
      return fail(ErrorCode::failed_precondition, reasons::kNothingToMake,
                  fmt::format("what was chosen of diagnosis {} changes no model, correction or "
                              "row: {}",
                              id_.value,
                              found_.findings[static_cast<std::size_t>(chosen[0] - 1)].sentence));
    return std::move(plan_);
  }

 private:
  Result<void> add(int number, const diagnosis::Finding& finding) {
    using effects::AppliesTo;
    const bool is_jump = finding.cause == "step_change";
    if (finding.applies_to == AppliesTo::robot) {
      for (const auto& term : finding.terms) plan_.formula += " + " + effects::notation(term);
      plan_.extends_model |= !finding.terms.empty();
      return {};
    }
    if (is_jump) return split_datum(finding);
    if (diagnosis::correction_is_uncertain(finding))
      return fail(ErrorCode::failed_precondition, reasons::kUncertainCorrection,
                  fmt::format("finding {} {} stands, but nothing can be accepted of it: {}",
                              finding.cause, finding.subject, finding.sentence));
    if (finding.applies_to == AppliesTo::correction) return correct(number, finding);
    if (finding.cause == "sensor_fault") return leave_sensor_out(finding);
    if (finding.cause == "outliers") keep_rows_out(finding);
    return {};
  }

  // From the row on that is the first at or after its instant.
  Result<void> split_datum(const diagnosis::Finding& finding) {
    for (const auto& parameter : finding.parameters) {
      if (parameter.name != "time_s") continue;
      for (std::size_t row = 0; row < data_.data.time_s.size(); ++row)
        if (data_.data.time_s[row] >= parameter.value) {
          plan_.amendment.splits.push_back({data_.origins[row].run, data_.origins[row].row});
          return {};
        }
    }
    return {};
  }

  Result<void> leave_sensor_out(const diagnosis::Finding& finding) {
    const auto* column = data_.data.find(finding.subject);
    if (column != nullptr && is_structure_temperature(column->channel))
      for (const RunId run : runs_in(data_))
        plan_.amendment.sensors.push_back({run, finding.subject});
    else
      keep_rows_out(finding);
    return {};
  }

  void keep_rows_out(const diagnosis::Finding& finding) {
    for (const std::size_t row : finding.rows) {
      if (row >= data_.origins.size()) continue;
      rows_out_[data_.origins[row].run].push_back(data_.origins[row].row);
      reason_of_[data_.origins[row].run] =
          finding.cause + (finding.subject.empty() ? "" : " " + finding.subject);
    }
  }

  Result<void> correct(int number, const diagnosis::Finding& finding) {
    if (finding.terms.empty()) return {};
    if (auto ok = find_slopes(); !ok) return ok;
    const auto outputs = static_cast<Eigen::Index>(outputs_.size());
    const auto terms = static_cast<Eigen::Index>(finding.terms.size());
    Eigen::MatrixXd seen = Eigen::MatrixXd::Zero(outputs, terms);  // mm of q per unit of a term
    for (const auto& output : finding.outputs) {
      const auto at = std::ranges::find(outputs_, output.output, &Channel::symbol);
      if (at == outputs_.end() || output.coefficients.size() != finding.terms.size()) continue;
      const double mm_per_unit = mm_from_nm(summary_unit(at->unit).factor);
      for (Eigen::Index j = 0; j < terms; ++j)
        seen(at - outputs_.begin(), j) =
            mm_per_unit * output.coefficients[static_cast<std::size_t>(j)];
    }
    // q = f(pose read - e) = f(pose read) - slopes e: what was seen in q is - slopes e.
    const auto only = std::ranges::find(axes_, finding.subject);
    const auto first = only == axes_.end() ? 0 : only - axes_.begin();
    const auto count = only == axes_.end() ? static_cast<Eigen::Index>(axes_.size()) : 1;
    const Eigen::MatrixXd slopes = slopes_.middleCols(first, count);
    const Eigen::MatrixXd error_mm = -slopes.colPivHouseholderQr().solve(seen);
    const InstrumentClaim claim{
        outputs_, {axes_.begin() + first, axes_.begin() + first + count}, slopes, seen, error_mm};
    if (auto ok = check_instrument(number, finding, claim, data_.data); !ok) return ok;
    const bool is_timed = reads_data_time(finding.terms);
    for (Eigen::Index i = 0; i < count; ++i) {
      correction::LengthShift shift;
      shift.axis = axes_[static_cast<std::size_t>(first + i)];
      shift.terms = finding.terms;
      for (Eigen::Index j = 0; j < terms; ++j) shift.mm.push_back(error_mm(i, j));
      if (auto ok = correction::count_from_first(data_.data, shift.terms, shift.mm); !ok) return ok;
      if (is_timed) {
        shift.runs = runs_in(data_);
        shift.clock_origin = data_.time_zero;
      }
      plan_.amendment.shifts.push_back(std::move(shift));
    }
    return {};
  }

  // Of the simulation it began from, fitted to the same data.
  Result<void> find_slopes() {
    if (!axes_.empty()) return {};
    calibration::FitOptions options;
    options.select = calibration::Select::stepwise;
    DRIFTWISE_TRY(const auto model,
                  formats::fit_formula(data_.data, found_.baseline_formula, options));
    for (const auto& output : model.outputs) outputs_.push_back(output.channel);
    for (const auto& range : model.domain)
      if (is_pose_symbol(range.channel.symbol) && is_length(range.channel.unit) &&
          range.max > range.min)
        axes_.push_back(range.channel.symbol);
    if (axes_.empty())
      return fail(ErrorCode::failed_precondition, reasons::kNoLength,
                  fmt::format("the simulation {} reads no measured length: an instrument's error "
                              "cannot be corrected in it",
                              found_.baseline_formula));
    DRIFTWISE_TRY(auto slopes, simulation::motor_slopes(model, axes_));
    slopes_ = std::move(slopes);
    return {};
  }

  DiagnosisId id_;
  const diagnosis::Diagnosis& found_;
  const RunsData& data_;
  ExtensionPlan plan_;
  std::map<RunId, std::vector<std::int64_t>> rows_out_;
  std::map<RunId, std::string> reason_of_;
  std::vector<Channel> outputs_;
  std::vector<std::string> axes_;
  Eigen::MatrixXd slopes_;
};

}  // namespace

Result<std::vector<int>> chosen_findings(const diagnosis::Diagnosis& found,
                                         std::vector<int> wanted) {
  const int count = static_cast<int>(found.findings.size());
  if (count == 0)
    return fail(ErrorCode::failed_precondition, reasons::kNothingFound,
                "the diagnosis names no cause: there is nothing to accept");
  const bool all = wanted.empty();
  for (int number = 1; all && number <= count; ++number)
    if (count == 1 ||
        !diagnosis::correction_is_uncertain(found.findings[static_cast<std::size_t>(number - 1)]))
      wanted.push_back(number);
  std::ranges::sort(wanted);
  const auto again = std::ranges::unique(wanted);
  wanted.erase(again.begin(), again.end());
  for (const int number : wanted) {
    if (number < 1 || number > count)
      return fail(ErrorCode::not_found, reasons::kNoSuchFinding,
                  fmt::format("there is no finding {}: the diagnosis has 1 to {}", number, count));
    const auto& finding = found.findings[static_cast<std::size_t>(number - 1)];
    if (all && !finding.indistinguishable_from.empty())
      return fail(ErrorCode::failed_precondition, reasons::kIndistinguishable,
                  fmt::format("finding {} ({} {}) cannot be told apart from {}: choose, by naming "
                              "the findings to accept, or measure what separates them",
                              number, finding.cause, finding.subject,
                              fmt::join(finding.indistinguishable_from, ", ")));
  }
  return wanted;
}

Result<ExtensionPlan> plan_extension(DiagnosisId id, const diagnosis::Diagnosis& found,
                                     const std::vector<int>& chosen, const RunsData& data) {
  const auto robot = formats::robot_of_formula(found.baseline_formula);
  if (robot.empty()) return Planner(id, found, data).plan(chosen);
  const formats::RobotNames names(data.data, robot);
  const auto bare = names.bare(found);
  const RunsData part{names.bare(data.data), data.origins, data.time_zero};
  auto plan = Planner(id, bare, part).plan(chosen);
  if (!plan) return tl::unexpected(names.with_id(std::move(plan.error())));
  plan->formula = names.with_id(plan->formula);
  plan->amendment = names.with_id(std::move(plan->amendment));
  return plan;
}

Result<void> put_in_force(const ExtensionPlan& plan, RunsData& data) {
  if (!plan.exclusions.empty() && data.data.excluded.empty())
    data.data.excluded.assign(data.data.rows, 0);
  for (const auto& exclusion : plan.exclusions)
    for (std::size_t row = 0; row < data.origins.size(); ++row)
      if (data.origins[row].run == exclusion.run &&
          std::ranges::binary_search(exclusion.rows, data.origins[row].row))
        data.data.excluded[row] = 1;
  return correction::amend(plan.amendment, data.origins, data.time_zero, data.data);
}

}  // namespace driftwise::application
