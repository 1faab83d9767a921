#include "server/application/diagnoses/extension_plan.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <map>

#include "server/application/diagnoses/instrument_agreement.h"
#include "server/application/diagnoses/taken_side.h"
#include "server/compensation/snapshot.h"
#include "server/core/data/row_marks.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/core/units.h"
#include "server/correction/first_conditions.h"
#include "server/diagnosis/report/sentence.h"
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
  Planner(DiagnosisId id, const diagnosis::Diagnosis& found, const RunsData& data,
          std::string taken_as)
      : id_(id), found_(found), data_(data), taken_as_(std::move(taken_as)) {
    plan_.baseline = plan_.formula = found.baseline_formula;
  }

  Result<ExtensionPlan> plan(const std::vector<int>& chosen) {
    plan_.findings = chosen;
    for (const int number : chosen) {
      DRIFTWISE_TRY(const auto finding, with_side(number));
      DRIFTWISE_RETURN_IF_ERROR(add(number, finding));
    }
    DRIFTWISE_RETURN_IF_ERROR(drop_sensor_terms());
    if (!taken_as_.empty() && taken_as_ != kAsNamed && !took_side_)
      return fail(ErrorCode::failed_precondition, reasons::kNoSuchFinding,
                  fmt::format("none of the chosen findings of diagnosis {} may be the robot's as "
                              "well as an instrument's, so nothing is taken as '{}'",
                              id_.value, taken_as_));
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
    if (plan_.of_robot.empty() && plan_.amendment.empty() && plan_.exclusions.empty())
      return fail(ErrorCode::failed_precondition, reasons::kNothingToMake,
                  fmt::format("what was chosen of diagnosis {} changes no model, correction or "
                              "row: {}",
                              id_.value,
                              found_.findings[static_cast<std::size_t>(chosen[0] - 1)].sentence));
    return std::move(plan_);
  }

  // As it is taken where it may be the robot's or an instrument's; else as it is.
  Result<diagnosis::Finding> with_side(int number) {
    const auto& finding = found_.findings[static_cast<std::size_t>(number - 1)];
    const bool is_jump = finding.cause == "step_change";
    if (!is_jump && rivals_across(finding).empty()) return finding;
    if (taken_as_ == kAsNamed) return finding;
    if (!taken_as_.empty()) {
      took_side_ = true;
      return taken_as(found_, number, taken_as_, data_.data);
    }
    if (is_jump)
      if (const auto told = told_by_outputs(finding))
        return taken_as(found_, number, std::string(to_string(*told)), data_.data);
    return tl::unexpected(side_unknown(id_, found_, number));
  }

  // A target asks for the motors at a wanted pose and force: what follows one of them other than as
  // a power, or along a motor's path, has no value before it is there.
  static Result<void> check_servable(int number, const diagnosis::Finding& finding) {
    for (const auto& term : finding.terms)
      for (const auto& factor : term.factors) {
        const auto* call = std::get_if<effects::Call>(&factor);
        const auto* kind = call == nullptr ? nullptr : effects::find_effect(call->effect);
        if (kind == nullptr || kind->observes_path || kind->in_data_time) continue;
        for (const auto& symbol : call->symbols) {
          const bool is_motor = is_motor_symbol(symbol);
          if (!is_motor && !compensation::variable_from(symbol)) continue;
          return fail(
              ErrorCode::failed_precondition, reasons::kTermNotServable,
              fmt::format(
                  "finding {} ({}): its term {} follows {}, which a target asks for: it cannot be "
                  "served, and nothing was stored. {}",
                  number, name_of(finding), effects::notation(term), symbol,
                  is_motor ? "Correct the scale of that motor in its controller, measure again and "
                             "diagnose again"
                           : "Fit a formula with powers instead, such as F + F^2 + F^3, which "
                             "follow it over the loads that were hung"));
        }
      }
    return {};
  }

  std::optional<Side> told_by_outputs(const diagnosis::Finding& finding) {
    if (finding.terms.size() != 1 || !rivals_across(finding).empty() || !find_slopes())
      return std::nullopt;
    return side_of_jump(finding, {outputs_, axes_, slopes_, seen_mm(finding), {}});
  }

  Result<void> add(int number, const diagnosis::Finding& finding) {
    using effects::AppliesTo;
    const bool is_jump = finding.cause == "step_change";
    if (finding.applies_to == AppliesTo::robot) {
      if (finding.terms.empty()) return {};
      if (auto ok = check_servable(number, finding); !ok) return ok;
      if (!is_jump)
        for (const auto& term : finding.terms) plan_.formula += " + " + effects::notation(term);
      plan_.extends_model |= !is_jump;
      plan_.of_robot.push_back(finding);
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
        if (data_.data.time_s[row] >= parameter.value && !is_passage(data_.data, row)) {
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

  bool reads_left_out(const effects::Term& term) const {
    const auto symbols = effects::symbols_of(term);
    return std::ranges::any_of(plan_.amendment.sensors, [&](const auto& out) {
      return std::ranges::find(symbols, out.symbol) != symbols.end();
    });
  }

  // A thermometer that is left out takes its terms out of the baseline; a group such as T, which
  // does without it, stays as it is written.
  Result<void> drop_sensor_terms() {
    if (plan_.amendment.sensors.empty()) return {};
    for (const auto& finding : plan_.of_robot)
      if (const auto reads = std::ranges::find_if(
              finding.terms, [this](const auto& term) { return reads_left_out(term); });
          reads != finding.terms.end())
        return fail(
            ErrorCode::failed_precondition, reasons::kNothingToMake,
            fmt::format("finding {} of diagnosis {} has the term {}, and a thermometer that "
                        "it reads is left out by another finding that was chosen: accept "
                        "one of the two",
                        name_of(finding), id_.value, effects::notation(*reads)));
    DRIFTWISE_TRY(const auto formula, formats::Formula::parse(plan_.baseline));
    DRIFTWISE_TRY(auto kept, formula.expand(data_.data));
    const auto dropped =
        std::erase_if(kept.terms, [this](const auto& term) { return reads_left_out(term); });
    Dataset without;
    without.metadata = data_.data.metadata;
    for (const auto& column : data_.data.columns)
      if (std::ranges::find(plan_.amendment.sensors, column.channel.symbol,
                            &correction::SensorLeftOut::symbol) == plan_.amendment.sensors.end())
        without.columns.push_back({column.channel, {}});
    const auto as_written = formula.expand(without);
    if (dropped == 0 || (as_written && as_written->terms == kept.terms)) return {};
    std::vector<std::string> terms;
    for (const auto& term : kept.terms) terms.push_back(effects::notation(term));
    if (terms.empty()) terms.emplace_back("1");
    const std::string written = fmt::format("{} ~ {}{}", fmt::join(kept.outputs, " + "),
                                            fmt::join(terms, " + "), kept.constant ? "" : " - 1");
    plan_.formula = written + plan_.formula.substr(plan_.baseline.size());
    plan_.baseline = written;
    return {};
  }

  void keep_rows_out(const diagnosis::Finding& finding) {
    for (const std::size_t row : finding.rows) {
      if (row >= data_.origins.size() || is_passage(data_.data, row)) continue;
      rows_out_[data_.origins[row].run].push_back(data_.origins[row].row);
      reason_of_[data_.origins[row].run] =
          finding.cause + (finding.subject.empty() ? "" : " " + finding.subject);
    }
  }

  Result<void> correct(int number, const diagnosis::Finding& finding) {
    if (finding.terms.empty()) return {};
    if (auto ok = find_slopes(); !ok) return ok;
    const auto terms = static_cast<Eigen::Index>(finding.terms.size());
    const Eigen::MatrixXd seen = seen_mm(finding);
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
    const bool of_file = std::ranges::any_of(data_.origins, &correction::RowOrigin::of_file);
    for (Eigen::Index i = 0; i < count; ++i) {
      correction::LengthShift shift;
      shift.axis = axes_[static_cast<std::size_t>(first + i)];
      shift.terms = finding.terms;
      for (Eigen::Index j = 0; j < terms; ++j) shift.mm.push_back(error_mm(i, j));
      if (auto ok = correction::count_from_first(data_.data, shift.terms, shift.mm); !ok) return ok;
      if (is_timed || of_file) shift.runs = runs_in(data_);
      if (is_timed) shift.clock_origin = data_.time_zero;
      plan_.amendment.shifts.push_back(std::move(shift));
    }
    return {};
  }

  // Outputs x terms: mm of q per unit of a term.
  Eigen::MatrixXd seen_mm(const diagnosis::Finding& finding) const {
    const auto outputs = static_cast<Eigen::Index>(outputs_.size());
    const auto terms = static_cast<Eigen::Index>(finding.terms.size());
    Eigen::MatrixXd seen = Eigen::MatrixXd::Zero(outputs, terms);
    for (const auto& output : finding.outputs) {
      const auto at = std::ranges::find(outputs_, output.output, &Channel::symbol);
      if (at == outputs_.end() || output.coefficients.size() != finding.terms.size()) continue;
      const double mm_per_unit = mm_from_nm(summary_unit(at->unit).factor);
      for (Eigen::Index j = 0; j < terms; ++j)
        seen(at - outputs_.begin(), j) =
            mm_per_unit * output.coefficients[static_cast<std::size_t>(j)];
    }
    return seen;
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
  std::string taken_as_;
  bool took_side_ = false;
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
    const std::string alias = finding.terms.empty() ? "" : diagnosis::aliases_note(finding);
    if (all && !alias.empty())
      return fail(
          ErrorCode::failed_precondition, reasons::kIndistinguishable,
          fmt::format("finding {0} has a period that these data cannot tell: {1}. Where you "
                      "know the period, accept it by its number (--finding {0})",
                      number, alias));
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
                                     const std::vector<int>& chosen, const RunsData& data,
                                     const std::string& taken_as) {
  const auto robot = formats::robot_of_formula(found.baseline_formula);
  if (robot.empty()) return Planner(id, found, data, taken_as).plan(chosen);
  const formats::RobotNames names(data.data, robot);
  const auto bare = names.bare(found);
  const RunsData part{names.bare(data.data), data.origins, data.time_zero};
  auto plan = Planner(id, bare, part, names.bare(taken_as)).plan(chosen);
  if (!plan) return tl::unexpected(names.with_id(std::move(plan.error())));
  plan->baseline = names.with_id(plan->baseline);
  plan->formula = names.with_id(plan->formula);
  plan->amendment = names.with_id(std::move(plan->amendment));
  diagnosis::Diagnosis of_robot;
  of_robot.findings = std::move(plan->of_robot);
  plan->of_robot = names.with_id(std::move(of_robot)).findings;
  return plan;
}

Reach reach_of(const diagnosis::Finding& finding) {
  using effects::AppliesTo;
  if (finding.cause == "step_change") return Reach::own_runs;
  if (finding.applies_to == AppliesTo::dataset) return Reach::marks;
  const bool is_timed = reads_data_time(finding.terms);
  return finding.applies_to == AppliesTo::correction && is_timed ? Reach::own_runs
                                                                 : Reach::every_run;
}

std::vector<int> with_known_side(const diagnosis::Diagnosis& found, std::vector<int> numbers,
                                 const RunsData& data) {
  std::erase_if(numbers, [&](int number) {
    const auto plan = plan_extension(DiagnosisId{}, found, {number}, data);
    return !plan && plan.error().reason == reasons::kIndistinguishable;
  });
  return numbers;
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
