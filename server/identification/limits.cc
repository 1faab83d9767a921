#include "server/identification/limits.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "server/identification/bench.h"

namespace driftwise::identification {
namespace {

constexpr double kNinety = 1.645;  // accuracy.h
constexpr double kHalfAsBadAgain = 1.5, kMost = 0.5, kMostRepeats = 1.1, kSlowRows = 10,
                 kLackOfFit = 0.01;

std::string figure(double value, const std::string& unit) {
  char text[64];
  std::snprintf(text, sizeof text, "%.3g %s", value, unit.c_str());
  return text;
}

std::string percent(double share) { return figure(std::round(100 * share), "%"); }

double share_of_variance(double part, double whole) {
  return whole > 0 ? part * part / (whole * whole) : 0;
}

}  // namespace

Limit limited_by(const LimitFacts& f) {
  const double held_out = std::max(f.a90_blocks.value_or(0), f.a90_validation.value_or(0)) > 0
                              ? std::max(f.a90_blocks.value_or(0), f.a90_validation.value_or(0))
                              : f.a90_calibration;
  const std::string of = " of an A90 of " + figure(held_out, f.unit);
  if (!f.uncovered.empty() && f.a90_validation &&
      *f.a90_validation > kHalfAsBadAgain * f.a90_blocks.value_or(f.a90_calibration)) {
    std::string list;
    for (const auto& one : f.uncovered) list += (list.empty() ? "" : ", ") + one;
    return {"temperatures", "temperatures that the calibration rows do not cover (" + list +
                                "): calibrate over a wider range"};
  }
  const double repeats = f.pure_error ? kNinety * *f.pure_error : 0;
  const double repeat_share = share_of_variance(repeats, held_out);
  // Repeats that differ by more than the model leaves differ by what it reads: temperatures.
  if (repeat_share >= kMost && repeats <= kMostRepeats * held_out)
    return {"noise",
            "noise of instruments and axes: repeats of a pose alone make " +
                figure(repeats, f.unit) + of + ", " + percent(std::min(1.0, repeat_share)) +
                " of its variance; no term of the pose can lower that. More readings per point "
                "can, or a term of what differs between the visits: the side they came from, the "
                "hour"};
  if (f.slow_share >= kMost && f.slow_rows >= kSlowRows)
    return {"drift", "drift that no term reads: " + percent(f.slow_share) +
                         " of the variance left is slow, over about " +
                         figure(f.slow_rows, "rows") +
                         "; add temperatures with their lags, or diagnose"};
  if (f.pure_error && repeat_share < kMost && f.lack_of_fit_p.value_or(0) < kLackOfFit)
    return {"lack_of_fit", "lack of fit: repeats of a pose make " + figure(repeats, f.unit) + of +
                               ", " + percent(repeat_share) +
                               " of its variance; the terms leave the rest: `driftwise model "
                               "grow` tries groups of terms, `driftwise diagnose` causes"};
  if (f.a90_blocks && *f.a90_blocks > kHalfAsBadAgain * f.a90_calibration)
    return {"rows", "too few rows for so many terms: " + figure(*f.a90_blocks, f.unit) +
                        " held out, " + figure(f.a90_calibration, f.unit) +
                        " on its own rows; `driftwise model points` says what more would buy"};
  return {"unknown",
          "noise or lack of fit, which these rows cannot tell apart: visit some poses again"};
}

std::optional<Limit> target_limited_by(const TargetLimitFacts& f) {
  const double share = share_of_variance(f.instrument_u90, f.u90);
  if (share < kMost) return std::nullopt;
  return Limit{"instrument", "the instrument " + f.instrument + ": its declared uncertainty is " +
                                 figure(f.instrument_u90, f.unit) + " of a stated 1.645 u of " +
                                 figure(f.u90, f.unit) + ", " + percent(std::min(1.0, share)) +
                                 " of its variance"};
}

LimitFacts limit_facts(const Dataset& dataset, const calibration::Model& model,
                       const calibration::OutputModel& output) {
  const SummaryUnit summary = summary_unit(output.channel.unit);
  const auto& a = output.accuracy;
  const auto scaled = [&](const std::optional<double>& value) {
    return value ? std::optional(*value * summary.factor) : std::nullopt;
  };
  LimitFacts facts{.unit = summary.unit,
                   .a90_calibration = a.a90_calibration * summary.factor,
                   .a90_blocks = scaled(a.a90_blocks),
                   .a90_validation = scaled(a.a90_validation),
                   .pure_error = scaled(a.pure_error),
                   .lack_of_fit_p = a.lack_of_fit_p,
                   .slow_share = a.slow_share,
                   .slow_rows = a.slow_rows};
  const auto validation = rows_in(dataset, PointSet::validation);
  for (const auto& range : model.domain) {
    if (!is_structure_temperature(range.channel)) continue;
    const auto* column = dataset.find(range.channel.symbol);
    if (column == nullptr) continue;
    double above = 0, below = 0;
    for (const std::size_t row : validation) {
      const double value = column->values[row];
      if (!std::isfinite(value)) continue;
      above = std::max(above, value - range.max);
      below = std::max(below, range.min - value);
    }
    // A tenth of the fitted range is not extrapolation worth a word.
    const double least = 0.1 * (range.max - range.min);
    if (above > least)
      facts.uncovered.push_back(range.channel.symbol + " " + figure(above, "K above"));
    if (below > least)
      facts.uncovered.push_back(range.channel.symbol + " " + figure(below, "K below"));
  }
  return facts;
}

}  // namespace driftwise::identification
