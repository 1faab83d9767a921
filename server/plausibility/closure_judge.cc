#include "server/plausibility/closure_judge.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace driftwise::plausibility {
namespace {

constexpr double kOtherForce_n = 0.02;  // the nearest of an actuator's own weights
constexpr double kNmPerUm = 1e3;

double before_of(const std::vector<double>& values, std::size_t i) {
  return i < values.size() && !is_missing(values[i]) ? values[i] : 0.0;
}

}  // namespace

void ClosureJudge::begin(CellTime at, std::optional<double> force_n) {
  last_ = {at, {}, {}, force_n};
}

ClosureVerdict ClosureJudge::judge(const Closure& closure) {
  const auto& rules = cell_.plausibility;
  const double minutes = std::max(0.0, seconds_from(closure.at - last_.at)) / 60;
  const double per_min = rules.closure_nm_per_min.value_or(cell_.checks.max_drift_nm_per_min);
  // Another force bends the robot: then only what the declared geometry allows is a limit.
  const bool same_force =
      std::abs(closure.force_n.value_or(0) - last_.force_n.value_or(0)) <= kOtherForce_n;
  const double limit_nm =
      rules.closure_nm + per_min * minutes + (same_force ? 0 : kNmPerUm * rules.geometry_um);
  const auto lengths = cell_.length_channels();
  const auto angles = cell_.angle_channels();
  ClosureVerdict verdict;
  const auto add = [&verdict](std::string text) {
    verdict.good = false;
    verdict.sentence += (verdict.sentence.empty() ? "" : ", ") + text;
  };
  for (std::size_t i = 0; i < closure.lengths_nm.size(); ++i) {
    if (is_missing(closure.lengths_nm[i])) continue;
    const double change_nm = closure.lengths_nm[i] - before_of(last_.lengths_nm, i);
    if (!(std::abs(change_nm) <= limit_nm))
      add(fmt::format("{} moved by {:+.0f} nm (limit {:.0f})",
                      i < lengths.size() ? lengths[i].symbol : "length", change_nm, limit_nm));
  }
  const double limit_arcsec = rules.closure_arcsec * (same_force ? 1 : 10);
  for (std::size_t i = 0; i < closure.angles_arcsec.size(); ++i) {
    if (is_missing(closure.angles_arcsec[i])) continue;
    const double change = closure.angles_arcsec[i] - before_of(last_.angles_arcsec, i);
    if (!(std::abs(change) <= limit_arcsec))
      add(fmt::format("{} turned by {:+.2f} arcsec (limit {:g})",
                      i < angles.size() ? angles[i].symbol : "angle", change, limit_arcsec));
  }
  if (!verdict.good) return verdict;
  const auto keep_missing = [](std::vector<double> now, const std::vector<double>& before) {
    for (std::size_t i = 0; i < now.size(); ++i)
      if (is_missing(now[i])) now[i] = before_of(before, i);
    return now;
  };
  last_ = {closure.at, keep_missing(closure.lengths_nm, last_.lengths_nm),
           keep_missing(closure.angles_arcsec, last_.angles_arcsec), closure.force_n};
  return verdict;
}

}  // namespace driftwise::plausibility
