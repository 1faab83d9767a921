#include "server/diagnosis/separating/separating_plans.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace driftwise::diagnosis {
namespace {

constexpr double kShortDwell_s = 1, kLongDwell_s = 100;
constexpr double kGolden = 0.6180339887498949;  // its multiples never come back
constexpr std::size_t kPerLine = 10;
constexpr std::size_t kMotionBlocks = 6;  // of moving and of resting, in turn
constexpr double kGrain = 1e-6;  // targets are whole nanometres, or millionths of an arcsec

class PlanWriter {
 public:
  PlanWriter(const PlanLimits& limits, std::string what) : limits_(limits) {
    plan_.what = std::move(what);
    plan_.trajectory.coordinates = limits.coordinates;
  }
  // share: 0 .. 1 of each axis' range.
  void visit(const std::vector<double>& share, double dwell_s = kShortDwell_s,
             std::optional<double> force_n = {}) {
    TrajectoryPoint point;
    for (std::size_t k = 0; k < share.size(); ++k) {
      const double at =
          limits_.min[k] + std::clamp(share[k], 0.0, 1.0) * (limits_.max[k] - limits_.min[k]);
      point.target.push_back(std::round(at / kGrain) * kGrain);
    }
    point.line = static_cast<std::int64_t>(plan_.trajectory.points.size() / kPerLine);
    point.dwell_s = dwell_s;
    point.force_n = force_n;
    plan_.trajectory.points.push_back(std::move(point));
  }
  std::size_t points() const { return plan_.trajectory.points.size(); }
  CandidatePlan done() { return std::move(plan_); }

 private:
  const PlanLimits& limits_;
  CandidatePlan plan_;
};

// Places that fill the range evenly however many they are: multiples of irrational numbers.
std::vector<double> spread_place(const PlanLimits& limits, std::size_t number,
                                 double margin = 0.1) {
  static constexpr double kSteps[] = {kGolden,
                                      0.7548776662466927,
                                      0.5698402909980532,
                                      0.8191725133961645,
                                      0.6710436067037893,
                                      0.5497004779019703};
  std::vector<double> share;
  for (std::size_t k = 0; k < limits.coordinates.size(); ++k) {
    const double turned = 0.5 + static_cast<double>(number + 1) * kSteps[k % 6];
    share.push_back(margin + (1 - 2 * margin) * (turned - std::floor(turned)));
  }
  return share;
}

std::vector<double> shifted(std::vector<double> share, double by) {
  for (double& one : share) one = std::clamp(one + by, 0.0, 1.0);
  return share;
}

// Backlash against creep: either side, short and long.
CandidatePlan dwell_contrast(const PlanLimits& limits, std::size_t points) {
  PlanWriter plan(limits, "the same places from either side, after 1 s and after 100 s");
  std::mt19937_64 random(11);
  for (std::size_t i = 0; plan.points() < points; ++i) {
    const auto place = spread_place(limits, i);
    const double from = random() % 2 == 0 ? 0.1 : -0.1;
    plan.visit(shifted(place, from));
    plan.visit(place, random() % 2 == 0 ? kShortDwell_s : kLongDwell_s);
  }
  return plan.done();
}

CandidatePlan both_sides(const PlanLimits& limits, std::size_t points) {
  PlanWriter plan(limits, "the same places approached from either side, in no regular order");
  std::mt19937_64 random(12);
  for (std::size_t i = 0; plan.points() < points; ++i) {
    const auto place = spread_place(limits, i / 2);
    plan.visit(shifted(place, random() % 2 == 0 ? 0.1 : -0.1));
    plan.visit(place);
  }
  return plan.done();
}

// Motion on and off while the room stays as it is.
CandidatePlan motion_on_off(const PlanLimits& limits, std::size_t points) {
  PlanWriter plan(limits, "motion on and off in turn at a constant room temperature");
  const std::size_t block = std::max<std::size_t>(4, points / kMotionBlocks);
  for (std::size_t i = 0; plan.points() < points; ++i) {
    const bool moving = (i / block) % 2 == 0;
    std::vector<double> share(limits.coordinates.size(), 0.5);
    if (moving) share.assign(share.size(), i % 2 == 0 ? 0.05 : 0.95);
    plan.visit(share, moving ? 0 : kShortDwell_s * 10);
  }
  return plan.done();
}

CandidatePlan irrational_steps(const PlanLimits& limits, std::size_t points) {
  PlanWriter plan(limits, "places at irrational steps over the whole range");
  for (std::size_t i = 0; plan.points() < points; ++i) plan.visit(spread_place(limits, i, 0.02));
  return plan.done();
}

// Some periods' length, in the middle of the range, at steps that meet every phase.
CandidatePlan fine_steps(const PlanLimits& limits, std::size_t points) {
  constexpr double kPeriods = 12;
  PlanWriter plan(limits, "a fine scan over twelve periods at irrational steps of the period");
  for (std::size_t i = 0; plan.points() < points; ++i) {
    std::vector<double> share;
    for (std::size_t k = 0; k < limits.coordinates.size(); ++k) {
      const double length = std::min(kPeriods * *limits.period, limits.max[k] - limits.min[k]);
      const double turned = static_cast<double>(i + 1) * kGolden;
      const double at = turned - std::floor(turned) - 0.5;
      share.push_back(0.5 + at * length / (limits.max[k] - limits.min[k]));
    }
    plan.visit(share);
  }
  return plan.done();
}

// Each force as often as the others, in an order that goes with nothing.
CandidatePlan random_forces(const PlanLimits& limits, std::size_t points) {
  PlanWriter plan(limits, "forces in random order at the same places");
  std::mt19937_64 random(13);
  std::vector<double> forces;
  for (std::size_t i = 0; plan.points() < points; ++i) {
    if (forces.empty()) {
      forces = limits.forces_n;
      for (std::size_t k = forces.size(); k > 1; --k)
        std::swap(forces[k - 1], forces[random() % k]);
    }
    const double force_n = forces.back();
    forces.pop_back();
    for (std::size_t k = 0; k < 4 && plan.points() < points; ++k)
      plan.visit(spread_place(limits, k), kShortDwell_s, force_n);
  }
  return plan.done();
}

CandidatePlan repeats(const PlanLimits& limits, std::size_t points) {
  PlanWriter plan(limits, "five places again and again, hours long");
  for (std::size_t i = 0; plan.points() < points; ++i)
    plan.visit(spread_place(limits, i % 5), kLongDwell_s / 2);
  return plan.done();
}

}  // namespace

std::vector<CandidatePlan> candidate_plans(const PlanLimits& limits, std::size_t points) {
  std::vector<CandidatePlan> plans;
  for (const auto design : {dwell_contrast, both_sides, motion_on_off, irrational_steps, repeats})
    plans.push_back(design(limits, points));
  if (limits.forces_n.size() > 1) plans.push_back(random_forces(limits, points));
  if (limits.period) plans.push_back(fine_steps(limits, points));
  return plans;
}

}  // namespace driftwise::diagnosis
