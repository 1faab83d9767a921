#include "server/diagnosis/separating/separating.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "server/core/try.h"
#include "server/core/units.h"
#include "server/diagnosis/separating/hypothesis.h"
#include "server/diagnosis/separating/separating_power.h"

namespace driftwise::diagnosis {
namespace {

constexpr std::size_t kFewestPoints = 24, kMostPoints = 3072;
constexpr std::size_t kMostForces = 12;
// Motors that share the pose have corners of their ranges where none of them can be with the
// others: the ranges shrink about their middle by this factor, to an eighth at least, until every
// corner has a pose, and one no farther out than the data by this share of their range.
constexpr double kShrink = 0.8, kSmallestShare = 0.125, kBeyondData = 0.1;

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
  return text;
}

std::vector<std::string> names_of(const std::vector<Hypothesis>& hypotheses) {
  std::vector<std::string> names;
  for (const auto& one : hypotheses) names.push_back(one.name);
  return names;
}

// "force_compliance F and (thermal_offset t04 or thermal_offset t05)"
std::string listed_by_class(const std::vector<Hypothesis>& hypotheses,
                            const SeparatingPower& power) {
  std::vector<std::string> names(power.classes);
  std::vector<int> members(power.classes, 0);
  for (std::size_t i = 0; i < hypotheses.size(); ++i) {
    auto& name = names[power.class_of[i]];
    name += (name.empty() ? "" : " or ") + hypotheses[i].name;
    ++members[power.class_of[i]];
  }
  for (std::size_t c = 0; c < names.size(); ++c)
    if (members[c] > 1) names[c] = "(" + names[c] + ")";
  return listed(names);
}

// What is past, or what nobody in the cell can move.
std::string beyond_reach(const std::vector<Hypothesis>& hypotheses) {
  const auto is = [](const std::string& cause, std::initializer_list<const char*> names) {
    return std::ranges::any_of(names, [&](const char* name) { return cause == name; });
  };
  bool slow = true;
  for (const auto& one : hypotheses) {
    if (one.cause == "step_change") return "a jump in the past does not come back to be measured";
    slow = slow && is(one.cause, {"thermal_offset", "thermal_lag", "thermal_rate",
                                  "thermal_expansion", "instrument_drift", "refractive_index"});
  }
  if (slow)
    return "they differ only while temperatures or the air change, and no device of the cell "
           "changes those: measure while the room heats, cools and returns";
  return "";
}

std::vector<std::pair<Channel, double>> conditions_at_end(const Dataset& dataset) {
  std::vector<std::pair<Channel, double>> conditions;
  for (const auto& column : dataset.columns) {
    if (is_motor_symbol(column.channel.symbol)) continue;
    double last = kMissing;
    for (const double value : column.values)
      if (std::isfinite(value)) last = value;
    conditions.emplace_back(column.channel, last);
  }
  return conditions;
}

struct Tried {
  CandidatePlan plan;
  double total_s = 0;
  SeparatingPower power;
};

std::size_t hypotheses_left(const Tried& one) {
  return one.power.class_of.size() - one.power.classes;
}

class Designer {
 public:
  Designer(const Dataset& dataset, const calibration::Candidates& baseline,
           const Diagnosis& diagnosis, SeparatingLimits limits)
      : dataset_(dataset), baseline_(baseline), diagnosis_(diagnosis), limits_(std::move(limits)) {}

  Result<SeparatingPlan> design(std::vector<Hypothesis> hypotheses) {
    calibration::FitOptions fitting;
    fitting.candidates = baseline_;
    fitting.select = calibration::Select::all;
    DRIFTWISE_TRY(const auto model, calibration::fit(dataset_, fitting));
    shrink_to_reach(model);
    std::vector<Tried> promising;
    SeparatingPower best;
    for (std::size_t points = kFewestPoints; points <= kMostPoints; points *= 2) {
      for (auto& plan : candidate_plans(limits_.plan, points)) {
        const double total_s = simulation::point_times(plan.trajectory, limits_.times).total_s;
        if (total_s > limits_.budget_s) continue;
        DRIFTWISE_TRY(auto rows, rows_of_plan(model, plan.trajectory));
        DRIFTWISE_TRY(auto power,
                      separating_power(rows, model_terms(), hypotheses, diagnosis_.outputs, 0, 1));
        best.expected_2lnl = std::max(best.expected_2lnl, power.expected_2lnl);
        if (power.classes > 1) promising.push_back({std::move(plan), total_s, power});
      }
    }
    // What tells most apart, and of those the shortest.
    std::ranges::stable_sort(promising, {}, [](const Tried& one) {
      return std::pair(hypotheses_left(one), one.total_s);
    });
    for (auto& one : promising) {
      DRIFTWISE_TRY(auto rows, rows_of_plan(model, one.plan.trajectory));
      DRIFTWISE_TRY(auto power,
                    separating_power(rows, model_terms(), hypotheses, diagnosis_.outputs,
                                     limits_.simulations, limits_.seed));
      best.power = std::max(best.power, power.power);
      if (power.power < limits_.min_power) continue;
      std::string why = listed_by_class(hypotheses, power) + " are told apart by " + one.plan.what +
                        ", if the room stays as it is";
      if (power.classes < hypotheses.size())
        why +=
            "; what is joined by \"or\" stays together: nothing within the limits tells it apart";
      return SeparatingPlan{.why = std::move(why),
                            .predicted_power = power.power,
                            .trajectory = std::move(one.plan.trajectory),
                            .estimated_s = one.total_s};
    }
    return none(hypotheses, best);
  }

 private:
  // Leaves the ranges as they are where no share of them helps: the error is then the plan's.
  void shrink_to_reach(const calibration::Model& model) {
    const PlanLimits whole = limits_.plan;
    for (double share = 1; share > kSmallestShare; share *= kShrink) {
      for (std::size_t k = 0; k < whole.coordinates.size(); ++k) {
        const double middle = 0.5 * (whole.min[k] + whole.max[k]),
                     half = 0.5 * (whole.max[k] - whole.min[k]);
        limits_.plan.min[k] = middle - share * half;
        limits_.plan.max[k] = middle + share * half;
      }
      if (has_poses_at_corners(model)) return;
    }
    limits_.plan = whole;
  }

  bool has_poses_at_corners(const calibration::Model& model) const {
    const PlanLimits& box = limits_.plan;
    Trajectory corners{.coordinates = box.coordinates, .points = {}};
    for (std::size_t corner = 0; corner < std::size_t{1} << box.coordinates.size(); ++corner) {
      TrajectoryPoint point;
      for (std::size_t k = 0; k < box.coordinates.size(); ++k)
        point.target.push_back((corner >> k & 1) == 0 ? box.min[k] : box.max[k]);
      corners.points.push_back(std::move(point));
    }
    const auto rows = rows_of_plan(model, corners);
    if (!rows) return false;
    return std::ranges::all_of(model.domain, [&](const auto& range) {
      if (!is_pose_symbol(range.channel.symbol)) return true;
      const double beyond = kBeyondData * (range.max - range.min);
      return std::ranges::all_of(rows->values_of(range.channel.symbol), [&](double value) {
        return value > range.min - beyond && value < range.max + beyond;
      });
    });
  }

  std::vector<effects::Term> model_terms() const { return baseline_.terms; }

  Result<Dataset> rows_of_plan(const calibration::Model& model,
                               const Trajectory& trajectory) const {
    const double start_s = dataset_.time_s.empty() ? 0 : dataset_.time_s.back() + 60;
    return simulation::planned_rows(model, trajectory, conditions_at_end(dataset_), limits_.times,
                                    start_s);
  }

  SeparatingPlan none(const std::vector<Hypothesis>& hypotheses,
                      const SeparatingPower& best) const {
    std::string why = beyond_reach(hypotheses);
    if (why.empty()) {
      why = "within " + std::to_string(std::lround(limits_.budget_s / 60)) +
            " min and the ranges allowed the best design separates them by 2 ln L = " +
            std::to_string(std::lround(best.expected_2lnl)) + ", and it takes " +
            std::to_string(std::lround(kIdentifiable2lnl));
      if (best.expected_2lnl > kIdentifiable2lnl)
        why += " and a power of " + std::to_string(std::lround(100 * limits_.min_power)) +
               " %, of which it reaches " + std::to_string(std::lround(100 * best.power)) + " %";
    }
    return {
        .why = "none within the limits because " + why + " (" + listed(names_of(hypotheses)) + ")",
        .predicted_power = {},
        .trajectory = {}};
  }

  const Dataset& dataset_;
  const calibration::Candidates& baseline_;
  const Diagnosis& diagnosis_;
  SeparatingLimits limits_;
};

// Of a hypothesis that is periodic along a coordinate, in its unit: the shortest one.
std::optional<double> shortest_period(const std::vector<Hypothesis>& hypotheses) {
  std::optional<double> shortest;
  for (const auto& one : hypotheses) {
    if (one.cause != "cyclic_error" || one.cells.empty()) continue;
    const auto* call = std::get_if<effects::Call>(&one.cells.front().terms.front().factors.front());
    if (call == nullptr || call->parameters.empty()) continue;
    const auto& period = call->parameters.front();
    const double own = period.unit == "nm" ? period.value / kNmPerMm : period.value;
    if (!shortest || own < *shortest) shortest = own;
  }
  return shortest;
}

// Of ascending forces at most kMostForces, with the smallest and the largest.
std::vector<double> spread_forces(std::vector<double> forces_n) {
  if (forces_n.size() <= kMostForces) return forces_n;
  std::vector<double> kept;
  for (std::size_t i = 0; i < kMostForces; ++i)
    kept.push_back(forces_n[i * (forces_n.size() - 1) / (kMostForces - 1)]);
  return kept;
}

}  // namespace

SeparatingLimits limits_from(const Dataset& dataset) {
  SeparatingLimits limits;
  for (const auto& column : dataset.columns) {
    const auto& unit = column.channel.unit;
    if (!is_motor_symbol(column.channel.symbol) || (unit != "mm" && unit != "arcsec")) continue;
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (const double value : column.values) {
      if (!std::isfinite(value)) continue;
      low = std::min(low, value);
      high = std::max(high, value);
    }
    if (low > high) continue;
    limits.plan.coordinates.push_back(column.channel);
    limits.plan.min.push_back(low);
    limits.plan.max.push_back(high);
  }
  std::set<double> forces;
  for (const double value : dataset.values_of("force"))
    if (std::isfinite(value)) forces.insert(value);
  limits.plan.forces_n = spread_forces({forces.begin(), forces.end()});
  return limits;
}

Result<std::optional<SeparatingPlan>> separating_plan(const Dataset& dataset,
                                                      const calibration::Candidates& baseline,
                                                      const Diagnosis& diagnosis,
                                                      const SeparatingLimits& limits) {
  std::optional<SeparatingPlan> first;
  for (std::size_t i = 0; i < diagnosis.findings.size(); ++i) {
    const auto& finding = diagnosis.findings[i];
    if (finding.terms.empty() ||
        (finding.indistinguishable_from.empty() && finding.cause != "cyclic_error" &&
         finding.cause != "periodic_disturbance"))
      continue;
    DRIFTWISE_TRY(auto hypotheses, open_hypotheses(dataset, baseline, diagnosis, i));
    if (hypotheses.size() < 2) continue;
    SeparatingLimits own = limits;
    if (own.plan.coordinates.empty()) own.plan = limits_from(dataset).plan;
    own.plan.period = shortest_period(hypotheses);
    DRIFTWISE_TRY(
        auto plan,
        Designer(dataset, baseline, diagnosis, std::move(own)).design(std::move(hypotheses)));
    if (plan.trajectory) return std::optional(std::move(plan));
    if (!first) first = std::move(plan);
  }
  return first;
}

}  // namespace driftwise::diagnosis
