#include "server/standards/approaches.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "server/core/data/overruns.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/standards/measured_columns.h"

namespace driftwise::standards {
namespace {

constexpr double kSameTarget_mm = 1e-9;
// Least move to or from a passage: less is what a compensation adds to a command between two looks
// at one place.
constexpr double kLeastMoveAside_mm = 1e-4;

std::string robot_prefix(const std::string& symbol) {
  const auto robot = robot_of(symbol);
  return robot.empty() ? std::string() : std::string(robot) + ".";
}

// "x" for q1 and x, "ma.x" for ma.q1; nothing for what is no axis of a position.
std::string pose_symbol_of(const std::string& axis) {
  const auto name = without_robot(axis);
  const char* pose = name == "q1" || name == "x"   ? "x"
                     : name == "q2" || name == "y" ? "y"
                     : name == "q3" || name == "z" ? "z"
                                                   : nullptr;
  return pose ? robot_prefix(axis) + pose : std::string();
}

std::string motor_symbol_of(const std::string& pose) {
  const auto name = without_robot(pose);
  return robot_prefix(pose) + (name == "x" ? "q1" : name == "y" ? "q2" : "q3");
}

// In older records commands of several robots are counted through the motors of all of them: q4_cmd
// may be that of ma.q1, and q1_cmd that of mn.q1.
bool has_robots(const Dataset& dataset) {
  return std::ranges::any_of(dataset.columns, [](const DatasetColumn& column) {
    const auto& symbol = column.channel.symbol;
    return !robot_of(symbol).empty() && is_motor_symbol(without_robot(symbol));
  });
}

// Symbol of what the axis was commanded to; nothing: no column is known to be its own.
std::string command_of(const Dataset& dataset, const AxisColumns& columns) {
  if (columns.target.ends_with("_cmd")) return columns.target;
  const auto pose = pose_symbol_of(columns.axis);
  const std::string own = (pose.empty() ? columns.axis : motor_symbol_of(pose)) + "_cmd";
  return has_robots(dataset) && robot_of(own).empty() ? std::string() : own;
}

// Where a row has the axis; either may be missing: a passage has no target.
struct Place {
  double target_mm = kMissing, command_mm = kMissing;
};

// 0: it stayed. kMissing: the two cannot be compared.
double move_between(const Place& from, const Place& to) {
  const double by_target_mm = to.target_mm - from.target_mm;
  if (std::abs(by_target_mm) <= kSameTarget_mm) return 0;
  const double by_command_mm = to.command_mm - from.command_mm;
  if (is_missing(by_command_mm)) return is_missing(by_target_mm) ? kMissing : by_target_mm;
  const double least_mm = is_missing(by_target_mm) ? kLeastMoveAside_mm : kSameTarget_mm;
  return std::abs(by_command_mm) <= least_mm ? 0 : by_command_mm;
}

ApproachSide other_side(ApproachSide side) {
  return side == ApproachSide::up     ? ApproachSide::down
         : side == ApproachSide::down ? ApproachSide::up
                                      : ApproachSide::unknown;
}

// "x_target, goal_x or q1_cmd".
std::string list_of(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "" : i + 1 == names.size() ? " or " : ", ") + names[i];
  return text;
}

}  // namespace

Result<AxisColumns> find_axis_columns(const Dataset& dataset, AxisColumns asked) {
  const std::string pose = pose_symbol_of(asked.axis);
  if (pose.empty() && (asked.target.empty() || asked.measured.empty()))
    return fail(ErrorCode::invalid_argument, reasons::kBadAxis,
                "found the axis '" + asked.axis +
                    "', expected q1, q2, q3, x, y or z (of one of several robots: ma.q1), or the "
                    "columns of "
                    "what was wanted and measured by name");
  if (asked.measured.empty()) asked.measured = pose;
  if (asked.target.empty()) {
    std::vector<std::string> names = {pose + "_target"};
    if (robot_of(pose).empty()) names.push_back("goal_" + pose);
    const std::string command = motor_symbol_of(pose) + "_cmd";
    if (!has_robots(dataset) || !robot_of(pose).empty()) names.push_back(command);
    asked.target = first_present(dataset, names);
    if (asked.target.empty() && dataset.find(command))
      return fail(ErrorCode::invalid_argument, reasons::kNoColumn,
                  "found " + command + " for the axis " + asked.axis +
                      " in data of several robots, which counts commands through the motors "
                      "of all robots in the order of the cell file: name the column of this axis' "
                      "command (--target q6_cmd)");
    if (asked.target.empty())
      return fail(ErrorCode::invalid_argument, reasons::kNoColumn,
                  "found no column of what was commanded along " + asked.axis + " (" +
                      list_of(names) +
                      "): name it, for the position of the scale is not what was wanted");
  }
  return asked;
}

Result<std::vector<Approach>> approaches_of(const Dataset& dataset, const AxisColumns& columns) {
  DRIFTWISE_TRY(const auto target_mm, column_mm(dataset, columns.target));
  DRIFTWISE_TRY(const auto measured_mm, column_mm(dataset, columns.measured));
  std::vector<double> command_mm(dataset.rows, kMissing);
  if (const auto name = command_of(dataset, columns); dataset.find(name)) {
    DRIFTWISE_TRY(command_mm, column_mm(dataset, name));
  }
  std::vector<std::size_t> rows;  // in which the axis was somewhere
  std::vector<double> move_mm;    // of each, from the one before
  Place before;
  for (std::size_t row = 0; row < dataset.rows; ++row) {
    const Place now{target_mm[row], command_mm[row]};
    if (is_missing(now.target_mm) && is_missing(now.command_mm)) continue;
    rows.push_back(row);
    move_mm.push_back(move_between(before, now));
    before = now;
  }
  const bool overruns = says_overruns(dataset);
  std::vector<Approach> out;
  ApproachSide side = ApproachSide::unknown;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::size_t row = rows[i];
    if (is_missing(move_mm[i])) side = ApproachSide::unknown;
    if (move_mm[i] > 0) side = ApproachSide::up;
    if (move_mm[i] < 0) side = ApproachSide::down;
    // Between a move and one back.
    const bool overran = overruns && move_mm[i] == 0 && i > 0 && i + 1 < rows.size() &&
                         move_mm[i - 1] * move_mm[i + 1] < 0;
    if (overran) side = other_side(side);
    if (dataset.is_excluded(row) || is_missing(target_mm[row])) continue;
    Approach approach;
    approach.target_mm = target_mm[row];
    approach.measured_mm = measured_mm[row];
    approach.side = side;
    approach.time_s = dataset.time_s.empty() ? 0 : dataset.time_s[row];
    approach.zero = !dataset.zero.empty() && dataset.zero[row] != 0;
    approach.moved = move_mm[i] != 0 || overran;
    if (!is_missing(approach.measured_mm)) out.push_back(approach);
  }
  return out;
}

std::vector<Position> positions_of(const std::vector<Approach>& approaches, bool with_returns) {
  std::vector<std::size_t> order(approaches.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return approaches[i].target_mm; });
  std::vector<Position> out;
  for (const std::size_t i : order) {
    const Approach& approach = approaches[i];
    if (approach.zero && !with_returns) continue;
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
