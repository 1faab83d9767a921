#include "tests/statistics/later_zeros/later_zero_case.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <random>
#include <stdexcept>

#include "drivers/simulated/plant/file/make_plant.h"
#include "server/compensation/snapshot_builder.h"
#include "server/compensation/target.h"
#include "server/core/units.h"
#include "server/formats/formula/formula.h"
#include "tests/statistics/linear_axis_case.h"
#include "tests/support/plant_campaign.h"

namespace driftwise::statistics {
namespace {

constexpr simulated::TimeNs kLaterEpoch = 1'600'000'000'000'000'000;
constexpr double kFirstZero_h = 6, kBack_h = 10, kFirstTarget_h = 12, kEnd_h = 16;

struct Visit {
  double time_s = 0, q_mm = 0, true_nm = 0;
  std::vector<ChannelValue> conditions;
};

Visit visit(simulated::LinearAxisPlant& plant, double to_mm, double time_s) {
  constexpr double kSettling_s = 11.5;
  const auto at = [](double s) { return kLaterEpoch + static_cast<simulated::TimeNs>(1e9 * s); };
  plant.start_move(0, to_mm, at(time_s));
  Visit out;
  out.time_s = time_s + kSettling_s;
  out.q_mm = plant.axis(0, at(out.time_s)).q_mm;
  out.true_nm = plant.truth(at(out.time_s)).end_effector_nm;
  const auto& probes = plant.parameters().thermometers;
  for (std::size_t i = 0; i < 10; ++i)
    out.conditions.push_back(
        {axis_sensor(i) + "_degC",
         testing_support::degc_from_ohm(plant.probe_ohm(probes[i].input, at(out.time_s)),
                                        probes[i].certificate_r0_ohm, probes[i].a_per_k,
                                        probes[i].b_per_k2)});
  return out;
}

std::vector<LaterTarget> judged(const calibration::Model& model, const CellDescription& cell,
                                const Visit& zero, const std::vector<Visit>& visits) {
  auto builder = compensation::SnapshotBuilder::create(model, ModelId{1}, cell);
  if (!builder) throw std::runtime_error(builder.error().message);
  auto values = zero.conditions;
  values.push_back({"q1_mm", zero.q_mm});
  builder->observe(values, CellTime{kLaterEpoch} + nanoseconds_from_s(zero.time_s));
  if (auto ok = builder->anchor(values); !ok) throw std::runtime_error(ok.error().message);
  std::vector<LaterTarget> out;
  for (const auto& one : visits) {
    const CellTime at = CellTime{kLaterEpoch} + nanoseconds_from_s(one.time_s);
    builder->observe(one.conditions, at);
    compensation::TargetRequest asked;
    asked.set(compensation::Variable::x, mm_from_nm(one.true_nm - zero.true_nm));
    auto snapshot = builder->build(at);
    const auto target = compensation::compute_target(snapshot, asked);
    if ((target.flags & compensation::kOutsideDomain) != 0) continue;
    LaterTarget later;
    later.zero_excess = snapshot.zero_excess;
    later.error_nm = nm_from_mm(target.q_mm[0] - one.q_mm);
    later.u_nm = target.u_nm[0];
    later.is_flagged = (target.flags & compensation::kZeroOutsideDomain) != 0;
    snapshot.zero_excess = 0;
    later.u_of_pose_nm = compensation::compute_target(snapshot, asked).u_nm[0];
    out.push_back(later);
  }
  return out;
}

}  // namespace

std::vector<std::vector<LaterTarget>> later_zeros(std::uint64_t seed, const LaterRoom& room) {
  std::mt19937_64 random(seed);
  const auto within = [&](double least, double most) {
    return std::uniform_real_distribution<double>(least, most)(random);
  };
  // The room leaves 20 degC for the campaign. While the zeros are taken it lies beyond either end
  // of that way, or on it; it comes back to the middle for the targets.
  const double way_k = (within(0, 1) < 0.5 ? -1 : 1) * within(0.5, 2);
  const double beyond_k = way_k * within(0.2, 1.2);
  const bool at_far_end = within(0, 1) < 0.5;
  const double at_zeros_k = room.stays_within ? way_k * within(0, 1)
                            : at_far_end      ? way_k + beyond_k
                                              : -beyond_k;
  char schedule[200];
  std::snprintf(schedule, sizeof schedule, "[[0.0833, %.4f], [4.0, %.4f], [%.1f, %.4f]]",
                20 + way_k, 20 + at_zeros_k, kBack_h, 20 + 0.5 * way_k);
  auto made = linear_axis_machine(seed, schedule);
  calibration::FitOptions options;
  options.select = room.select;
  const auto model = formats::fit_formula(made.measured.dataset, made.measured.formula, options);
  if (!model) throw std::runtime_error(model.error().message);
  std::vector<Visit> zeros, visits;
  for (double h = kFirstZero_h; h < kBack_h; h += 1)
    zeros.push_back(visit(*made.plant, 0, 3600 * h));
  std::uniform_real_distribution<double> anywhere(-3.5, 3.5);
  for (double h = kFirstTarget_h; h < kEnd_h; h += 0.2)
    visits.push_back(visit(*made.plant, anywhere(random), 3600 * h));
  std::vector<std::vector<LaterTarget>> out;
  for (const auto& zero : zeros) out.push_back(judged(*model, made.measured.cell, zero, visits));
  return out;
}

std::vector<LaterZeroCount::Class> LaterZeroCount::empty_classes() {
  constexpr std::array<double, 7> kEdges = {0, 1e-12, 0.1, 0.25, 0.5, 1, 1e300};
  std::vector<Class> out(kEdges.size() - 1);
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i].from = kEdges[i];
    out[i].to = kEdges[i + 1];
  }
  return out;
}

void LaterZeroCount::add(const std::vector<std::vector<LaterTarget>>& zeros) {
  for (auto& one : classes_) {
    const int targets = one.targets, hits = one.hits;
    for (const auto& of_zero : zeros) {
      if (of_zero.empty() || of_zero.front().zero_excess < one.from ||
          of_zero.front().zero_excess >= one.to)
        continue;
      ++one.zeros;
      for (const auto& target : of_zero) {
        ++one.targets;
        one.flagged += target.is_flagged ? 1 : 0;
        one.hits += std::abs(target.error_nm) <= 2 * target.u_nm ? 1 : 0;
        one.hits_of_pose += std::abs(target.error_nm) <= 2 * target.u_of_pose_nm ? 1 : 0;
        one.error_nm2 += target.error_nm * target.error_nm;
        one.ratio2 += std::pow(target.error_nm / target.u_nm, 2);
        one.ratio2_of_pose += std::pow(target.error_nm / target.u_of_pose_nm, 2);
        one.u_nm.push_back(target.u_nm);
      }
    }
    one.by_machine.add_campaign(one.hits - hits, one.targets - targets);
  }
}

std::string LaterZeroCount::table() const {
  std::string text =
      "zero outside by  zeros  targets  within 2u  95 % by machine  error/u  median u  pose alone: "
      "within 2u  error/u  rms error\n";
  for (const auto& one : classes_) {
    if (one.targets == 0) continue;
    const double n = one.targets;
    const auto interval = one.by_machine.clustered();
    auto u_nm = one.u_nm;
    const auto middle = u_nm.begin() + static_cast<std::ptrdiff_t>(u_nm.size() / 2);
    std::ranges::nth_element(u_nm, middle);
    char line[200];
    std::snprintf(line, sizeof line,
                  "%6.2f .. %6.2f  %5d  %7d   %6.1f %%  %5.1f .. %5.1f %%  %7.2f  %5.1f nm  "
                  "%19.1f %%  %7.2f  %6.1f nm\n",
                  one.from, std::min(one.to, 99.0), one.zeros, one.targets, 100 * one.rate(),
                  100 * interval.low, 100 * interval.high, std::sqrt(one.ratio2 / n), *middle,
                  100 * one.rate_of_pose(), std::sqrt(one.ratio2_of_pose / n),
                  std::sqrt(one.error_nm2 / n));
    text += line;
  }
  return text;
}

}  // namespace driftwise::statistics
