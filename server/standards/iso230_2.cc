#include "server/standards/iso230_2.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/core/units.h"
#include "server/standards/measured_columns.h"

namespace driftwise::standards {
namespace {

constexpr std::size_t kLeastPositions = 5;
constexpr double kLongestAxis_mm = 2000;

std::string mm_text(double mm) {
  char text[40];
  std::snprintf(text, sizeof text, "%.9g mm", mm);
  return text;
}

tl::unexpected<Error> lacks(Reason reason, const std::string& sentence) {
  return fail(ErrorCode::failed_precondition, reason, "ISO 230-2: " + sentence);
}

// Those between the outermost positions that were approached from both sides; beyond them the axis
// turned round. One approach may be the way in from where the run started: it makes no position.
std::vector<Position> tested(const std::vector<Position>& positions,
                             std::vector<double>& turning_points_mm) {
  const auto both = [](const Position& p) { return std::min(p.up.size(), p.down.size()) > 1; };
  const auto first = std::ranges::find_if(positions, both);
  if (first == positions.end()) return positions;
  const auto last = std::find_if(positions.rbegin(), positions.rend(), both).base();
  for (auto at = positions.begin(); at != positions.end(); ++at)
    if (at < first || at >= last) turning_points_mm.push_back(at->target_mm);
  return {first, last};
}

Result<void> check_positions(const std::vector<Position>& positions, std::size_t needed) {
  constexpr std::size_t kShown = 8;
  std::string missing;
  std::size_t count = 0;
  for (const auto& position : positions) {
    if (position.up.size() >= needed && position.down.size() >= needed) continue;
    if (++count <= kShown)
      missing += (missing.empty() ? "" : "; ") + mm_text(position.target_mm) + " has " +
                 std::to_string(position.up.size()) + " from below, " +
                 std::to_string(position.down.size()) + " from above";
  }
  if (count > kShown) missing += "; and " + std::to_string(count - kShown) + " more";
  if (count > 0)
    return lacks(reasons::kLacksApproaches,
                 "needs " + std::to_string(needed) +
                     " approaches from each side to every position: " + missing +
                     ". `driftwise trajectory iso230-2` writes a trajectory that has them");
  const double travel_mm =
      positions.empty() ? 0 : positions.back().target_mm - positions.front().target_mm;
  const auto wanted = std::max(
      kLeastPositions, static_cast<std::size_t>(std::ceil(
                           static_cast<double>(kLeastPositions) * travel_mm / 1000 - 1e-9)));
  if (positions.size() < wanted)
    return lacks(reasons::kTooFewPositions,
                 "needs " + std::to_string(wanted) + " positions over " + mm_text(travel_mm) +
                     ", found " + std::to_string(positions.size()) +
                     ". `driftwise trajectory iso230-2` writes a trajectory that has them");
  return {};
}

Iso2302Side side_figures(const std::vector<Approach>& visits, std::size_t count) {
  Iso2302Side out;
  std::vector<double> x_nm;
  for (std::size_t j = 0; j < count; ++j)
    x_nm.push_back(nm_from_mm(visits[j].measured_mm - visits[j].target_mm));
  const auto n = static_cast<double>(count);
  for (const double x : x_nm) out.mean_nm += x / n;
  double squares = 0;
  for (const double x : x_nm) squares += (x - out.mean_nm) * (x - out.mean_nm);
  out.s_nm = std::sqrt(squares / (n - 1));
  out.r_nm = 4 * out.s_nm;
  return out;
}

// Largest minus smallest of what is put in.
struct Extent {
  double low = std::numeric_limits<double>::infinity(),
         high = -std::numeric_limits<double>::infinity();
  void take(double from, double to) {
    low = std::min(low, from);
    high = std::max(high, to);
  }
  void take(const Extent& other) { take(other.low, other.high); }
  double size() const { return high - low; }
};

void axis_figures(Iso2302& out) {
  Extent mean_up, mean_down, mean_both, band_up, band_down;
  for (const auto& p : out.positions) {
    mean_up.take(p.up.mean_nm, p.up.mean_nm);
    mean_down.take(p.down.mean_nm, p.down.mean_nm);
    mean_both.take(p.mean_nm, p.mean_nm);
    band_up.take(p.up.mean_nm - 2 * p.up.s_nm, p.up.mean_nm + 2 * p.up.s_nm);
    band_down.take(p.down.mean_nm - 2 * p.down.s_nm, p.down.mean_nm + 2 * p.down.s_nm);
    out.r.up_nm = std::max(out.r.up_nm, p.up.r_nm);
    out.r.down_nm = std::max(out.r.down_nm, p.down.r_nm);
    out.r.both_nm = std::max(out.r.both_nm, p.r_nm);
    out.b_nm = std::max(out.b_nm, std::abs(p.reversal_nm));
    out.mean_b_nm += p.reversal_nm / static_cast<double>(out.positions.size());
  }
  out.e = {0, mean_up.size(), mean_down.size()};
  out.a = {0, band_up.size(), band_down.size()};
  out.m_nm = mean_both.size();
  mean_up.take(mean_down);
  band_up.take(band_down);
  out.e.both_nm = mean_up.size();
  out.a.both_nm = band_up.size();
}

void add_warnings(Iso2302& out, const std::vector<Position>& positions, const Dataset& dataset) {
  const auto needed = static_cast<std::size_t>(out.approaches);
  const auto more = std::ranges::count_if(
      positions, [&](const Position& p) { return p.up.size() > needed || p.down.size() > needed; });
  if (more > 0)
    out.warnings.push_back(std::to_string(more) + " positions were approached more than " +
                           std::to_string(needed) +
                           " times from a side: the first ones in time count");
  if (const std::size_t datums = datum_count(dataset); datums > 1)
    out.warnings.push_back("the rows lie in " + std::to_string(datums) +
                           " datums: a new zero in between is part of the figures");
  const double travel_mm = positions.back().target_mm - positions.front().target_mm;
  if (travel_mm > kLongestAxis_mm)
    out.warnings.push_back("the travel is " + mm_text(travel_mm) +
                           ": for axes over 2000 mm the standard has another cycle");
}

}  // namespace

Result<Iso2302> iso230_2(const Dataset& dataset, const Iso2302Options& options) {
  if (options.approaches < 5)
    return fail(ErrorCode::invalid_argument, reasons::kTooFewApproaches,
                "asked for " + std::to_string(options.approaches) +
                    " approaches from each side, the standard has 5");
  DRIFTWISE_TRY(const auto columns, find_axis_columns(dataset, options.columns));
  DRIFTWISE_TRY(auto approaches, approaches_of(dataset, columns));
  // A second reading at one place is no second approach.
  std::erase_if(approaches, [](const Approach& approach) { return !approach.moved; });
  Iso2302 out;
  const auto positions = tested(positions_of(approaches), out.turning_points_mm);
  const auto count = static_cast<std::size_t>(options.approaches);
  DRIFTWISE_RETURN_IF_ERROR(check_positions(positions, count));

  out.columns = columns;
  out.approaches = options.approaches;
  for (const auto& position : positions) {
    Iso2302Position p;
    p.target_mm = position.target_mm;
    p.up = side_figures(position.up, count);
    p.down = side_figures(position.down, count);
    p.mean_nm = (p.up.mean_nm + p.down.mean_nm) / 2;
    p.reversal_nm = p.up.mean_nm - p.down.mean_nm;
    p.r_nm = std::max(
        {2 * p.up.s_nm + 2 * p.down.s_nm + std::abs(p.reversal_nm), p.up.r_nm, p.down.r_nm});
    out.positions.push_back(p);
  }
  axis_figures(out);
  out.conditions = conditions_of(dataset);
  add_warnings(out, positions, dataset);
  return out;
}

}  // namespace driftwise::standards
