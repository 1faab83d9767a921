#include "server/standards/approaches.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/standards/measured_columns.h"

namespace driftwise::standards {
namespace {

constexpr double kSameTarget_mm = 1e-9;

// "x" for q1 and x; nothing for what is no axis of a position.
std::string pose_symbol_of(const std::string& axis) {
  if (axis == "q1" || axis == "x") return "x";
  if (axis == "q2" || axis == "y") return "y";
  if (axis == "q3" || axis == "z") return "z";
  return {};
}

std::string motor_symbol_of(const std::string& pose) {
  return pose == "x" ? "q1" : pose == "y" ? "q2" : "q3";
}

}  // namespace

Result<AxisColumns> find_axis_columns(const Dataset& dataset, AxisColumns asked) {
  const std::string pose = pose_symbol_of(asked.axis);
  if (pose.empty() && (asked.target.empty() || asked.measured.empty()))
    return fail(ErrorCode::invalid_argument, reasons::kBadAxis,
                "found the axis '" + asked.axis +
                    "', expected q1, q2, q3, x, y or z, or the columns of what was wanted and "
                    "measured by name");
  if (asked.measured.empty()) asked.measured = pose;
  if (asked.target.empty()) {
    const std::vector<std::string> names = {pose + "_target", "goal_" + pose,
                                            motor_symbol_of(pose) + "_cmd"};
    asked.target = first_present(dataset, names);
    if (asked.target.empty())
      return fail(ErrorCode::invalid_argument, reasons::kNoColumn,
                  "found no column of what was commanded along " + asked.axis + " (" + names[0] +
                      ", " + names[1] + " or " + names[2] +
                      "): name it, for the position of the scale is not what was wanted");
  }
  return asked;
}

Result<std::vector<Approach>> approaches_of(const Dataset& dataset, const AxisColumns& columns) {
  DRIFTWISE_TRY(const auto target_mm, column_mm(dataset, columns.target));
  DRIFTWISE_TRY(const auto measured_mm, column_mm(dataset, columns.measured));
  std::vector<Approach> out;
  double before_mm = kMissing;
  for (std::size_t row = 0; row < dataset.rows; ++row) {
    Approach approach;
    approach.target_mm = target_mm[row];
    if (is_missing(approach.target_mm)) continue;
    if (approach.target_mm > before_mm + kSameTarget_mm) approach.side = ApproachSide::up;
    if (approach.target_mm < before_mm - kSameTarget_mm) approach.side = ApproachSide::down;
    before_mm = approach.target_mm;
    if (dataset.is_excluded(row)) continue;
    approach.measured_mm = measured_mm[row];
    approach.time_s = dataset.time_s.empty() ? 0 : dataset.time_s[row];
    approach.zero = !dataset.zero.empty() && dataset.zero[row] != 0;
    if (!is_missing(approach.measured_mm)) out.push_back(approach);
  }
  return out;
}

std::vector<Position> positions_of(const std::vector<Approach>& approaches) {
  std::vector<std::size_t> order(approaches.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return approaches[i].target_mm; });
  std::vector<Position> out;
  for (const std::size_t i : order) {
    const Approach& approach = approaches[i];
    if (approach.zero) continue;
    if (out.empty() || approach.target_mm - out.back().target_mm > kSameTarget_mm)
      out.push_back({approach.target_mm, {}, {}, {}});
    auto& visits = approach.side == ApproachSide::up     ? out.back().up
                   : approach.side == ApproachSide::down ? out.back().down
                                                         : out.back().unknown;
    visits.push_back(approach);
  }
  return out;
}

}  // namespace driftwise::standards
