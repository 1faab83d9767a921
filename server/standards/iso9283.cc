#include "server/standards/iso9283.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <unordered_map>

#include "server/core/channel.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/core/units.h"
#include "server/standards/measured_columns.h"

namespace driftwise::standards {
namespace {

constexpr double kHalfTurn_arcsec = 648000;

double within_half_turn(double arcsec) { return std::remainder(arcsec, 2 * kHalfTurn_arcsec); }

struct PoseColumns {
  std::vector<std::string> axes, rotations;
  std::vector<std::vector<double>> command_mm, measured_mm;          // by axis
  std::vector<std::vector<double>> command_arcsec, measured_arcsec;  // by rotation
};

std::string commanded_as(const Dataset& dataset, const std::string& measured) {
  std::vector<std::string> names = {measured + "_target", "goal_" + measured};
  const std::string pose(without_robot(measured));
  const std::string robot = measured.substr(0, measured.size() - pose.size());
  if (pose == "x") names.push_back(robot + "q1_cmd");
  if (pose == "y") names.push_back(robot + "q2_cmd");
  if (pose == "z") names.push_back(robot + "q3_cmd");
  return first_present(dataset, names);
}

Result<void> append(std::vector<std::vector<double>>& to, Result<std::vector<double>> column) {
  DRIFTWISE_RETURN_IF_ERROR(column);
  to.push_back(std::move(*column));
  return {};
}

// The symbols asked for, or those of a pose that the dataset has.
Result<std::vector<std::pair<std::string, std::string>>> pairs_of(
    const Dataset& dataset, const std::vector<std::string>& command,
    const std::vector<std::string>& measured, const std::vector<std::string>& usual) {
  if (!measured.empty() && !command.empty() && command.size() != measured.size())
    return fail(ErrorCode::invalid_argument, reasons::kBadColumns,
                "found " + std::to_string(command.size()) + " columns of commands and " +
                    std::to_string(measured.size()) + " of measurements, expected as many");
  std::vector<std::pair<std::string, std::string>> out;
  for (std::size_t i = 0; i < (measured.empty() ? usual : measured).size(); ++i) {
    const std::string& name = (measured.empty() ? usual : measured)[i];
    if (measured.empty() && !dataset.find(name)) continue;
    out.emplace_back(i < command.size() ? command[i] : commanded_as(dataset, name), name);
  }
  return out;
}

Result<PoseColumns> columns_of(const Dataset& dataset, const Iso9283Options& options) {
  PoseColumns out;
  DRIFTWISE_TRY(const auto positions,
                pairs_of(dataset, options.command, options.measured, {"x", "y", "z"}));
  if (positions.empty())
    return fail(ErrorCode::invalid_argument, reasons::kNoColumn,
                "found none of x, y, z, expected at least one measured position");
  for (const auto& [command, measured] : positions) {
    if (command.empty())
      return fail(ErrorCode::invalid_argument, reasons::kNoColumn,
                  "found no column of what was commanded for " + measured + " (" + measured +
                      "_target, goal_" + measured + ", ...): name it");
    DRIFTWISE_RETURN_IF_ERROR(append(out.command_mm, column_mm(dataset, command)));
    DRIFTWISE_RETURN_IF_ERROR(append(out.measured_mm, column_mm(dataset, measured)));
    out.axes.push_back(measured);
  }
  DRIFTWISE_TRY(const auto rotations, pairs_of(dataset, options.rotation_command,
                                               options.rotation_measured, {"rx", "ry", "rz"}));
  for (const auto& [command, measured] : rotations) {
    if (command.empty())
      out.command_arcsec.emplace_back(dataset.rows, 0.0);
    else
      DRIFTWISE_RETURN_IF_ERROR(append(out.command_arcsec, column_arcsec(dataset, command)));
    DRIFTWISE_RETURN_IF_ERROR(append(out.measured_arcsec, column_arcsec(dataset, measured)));
    out.rotations.push_back(measured);
  }
  return out;
}

struct VisitedPose {
  std::size_t first_row;
  std::vector<std::size_t> rows;
};

bool is_measured(const PoseColumns& columns, std::size_t row) {
  for (const auto* set : {&columns.command_mm, &columns.measured_mm, &columns.command_arcsec,
                          &columns.measured_arcsec})
    for (const auto& column : *set)
      if (is_missing(column[row])) return false;
  return true;
}

bool same_command(const PoseColumns& columns, std::size_t a, std::size_t b,
                  const Iso9283Options& options) {
  for (const auto& column : columns.command_mm)
    if (std::abs(column[a] - column[b]) > options.same_pose_mm) return false;
  for (const auto& column : columns.command_arcsec)
    if (std::abs(within_half_turn(column[a] - column[b])) > options.same_pose_arcsec) return false;
  return true;
}

// Poses by where their first command lies, in cells much wider than two commands of one pose may
// differ: a row is compared with those of its cell, and of the next one at a border, not with all.
class PoseCells {
 public:
  PoseCells(const PoseColumns& columns, const Iso9283Options& options)
      : columns_(columns), options_(options) {}

  // Of the poses that may have this row's command, in the order in which they were added.
  std::vector<std::size_t> near(std::size_t row) const {
    std::vector<std::size_t> poses;
    for (const std::uint64_t cell : cells_at(row, 1))
      if (const auto at = cells_.find(cell); at != cells_.end())
        poses.insert(poses.end(), at->second.begin(), at->second.end());
    std::ranges::sort(poses);
    return poses;
  }
  void add(std::size_t row, std::size_t pose) { cells_[cells_at(row, 0).front()].push_back(pose); }

 private:
  // share: of what two commands of one pose may differ, to either side of the row's.
  std::vector<std::uint64_t> cells_at(std::size_t row, double share) const {
    std::vector<std::uint64_t> cells = {0};
    const auto along = [&](const std::vector<double>& column, double same, auto wrapped) {
      const double width = std::max(1024 * same, 1e-9);
      const auto index = [&](double value) {
        return std::floor(wrapped(value) / width) + 0.0;  // one zero, not two
      };
      const double low = index(column[row] - share * same * 1.001),
                   high = index(column[row] + share * same * 1.001);
      const std::size_t before = cells.size();
      if (low != high) cells.insert(cells.end(), cells.begin(), cells.end());
      for (std::size_t i = 0; i < cells.size(); ++i)
        cells[i] = (cells[i] ^ std::bit_cast<std::uint64_t>(i < before ? low : high)) *
                       0x9e3779b97f4a7c15u +
                   1;
    };
    for (const auto& column : columns_.command_mm)
      along(column, options_.same_pose_mm, [](double mm) { return mm; });
    for (const auto& column : columns_.command_arcsec)
      along(column, options_.same_pose_arcsec, within_half_turn);
    return cells;
  }

  const PoseColumns& columns_;
  const Iso9283Options& options_;
  std::unordered_map<std::uint64_t, std::vector<std::size_t>> cells_;
};

std::vector<VisitedPose> visited_poses(const Dataset& dataset, const PoseColumns& columns,
                                       const Iso9283Options& options) {
  std::vector<VisitedPose> out;
  PoseCells cells(columns, options);
  for (std::size_t row = 0; row < dataset.rows; ++row) {
    if (!dataset.zero.empty() && dataset.zero[row] != 0) continue;
    if (dataset.is_excluded(row) || !is_measured(columns, row)) continue;
    const auto near = cells.near(row);
    const auto known = std::ranges::find_if(near, [&](std::size_t pose) {
      return same_command(columns, out[pose].first_row, row, options);
    });
    if (known != near.end()) {
      out[*known].rows.push_back(row);
      continue;
    }
    cells.add(row, out.size());
    out.push_back({row, {row}});
  }
  return out;
}

std::string pose_text(const PoseColumns& columns, std::size_t row) {
  std::string out = "(";
  for (const auto& column : columns.command_mm) {
    char text[40];
    std::snprintf(text, sizeof text, "%s%.9g", out.size() > 1 ? ", " : "", column[row]);
    out += text;
  }
  return out + ") mm";
}

Result<void> check_cycles(std::vector<VisitedPose>& poses, const PoseColumns& columns,
                          const Iso9283Options& options) {
  const auto needed = static_cast<std::size_t>(options.cycles);
  const auto wanted = static_cast<std::size_t>(options.poses);
  const auto whole = [&](const VisitedPose& pose) { return pose.rows.size() >= needed; };
  const auto passing = [&](const VisitedPose& pose) { return pose.rows.size() * 5 < needed; };
  if (static_cast<std::size_t>(std::ranges::count_if(poses, whole)) >= wanted)
    std::erase_if(poses, passing);
  std::string missing;
  std::size_t shown = 0, lacking = 0;
  for (const auto& pose : poses) {
    if (whole(pose)) continue;
    ++lacking;
    if (++shown <= 8)
      missing += (missing.empty() ? "" : "; ") + pose_text(columns, pose.first_row) + " has " +
                 std::to_string(pose.rows.size());
  }
  const std::string advice = ". `driftwise trajectory iso9283` writes a trajectory that has them";
  if (lacking > 8) missing += "; and " + std::to_string(lacking - 8) + " more";
  if (lacking > 0)
    return fail(ErrorCode::failed_precondition, reasons::kLacksCycles,
                "ISO 9283: needs " + std::to_string(needed) + " cycles over each of " +
                    std::to_string(wanted) + " poses: " + missing + advice);
  if (poses.size() < wanted)
    return fail(ErrorCode::failed_precondition, reasons::kTooFewPoses,
                "ISO 9283: needs " + std::to_string(wanted) + " poses, found " +
                    std::to_string(poses.size()) + advice);
  return {};
}

double mean_of(const std::vector<double>& values) {
  double mean = 0;
  for (const double value : values) mean += value / static_cast<double>(values.size());
  return mean;
}

double deviation_of(const std::vector<double>& values) {
  const double mean = mean_of(values);
  double squares = 0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  return std::sqrt(squares / static_cast<double>(values.size() - 1));
}

void position_figures(const PoseColumns& columns, const VisitedPose& visited, bool accuracy,
                      Iso9283Pose& out) {
  const std::size_t n = visited.rows.size();
  std::vector<double> distance_nm(n, 0);  // squares first
  double ap2_nm2 = 0;
  for (std::size_t axis = 0; axis < columns.axes.size(); ++axis) {
    std::vector<double> deviation_nm;  // from the command
    for (const std::size_t row : visited.rows)
      deviation_nm.push_back(
          nm_from_mm(columns.measured_mm[axis][row] - columns.command_mm[axis][row]));
    const double mean_nm = mean_of(deviation_nm);
    for (std::size_t j = 0; j < n; ++j)
      distance_nm[j] += (deviation_nm[j] - mean_nm) * (deviation_nm[j] - mean_nm);
    if (accuracy) out.ap_axis_nm.push_back(mean_nm);
    ap2_nm2 += mean_nm * mean_nm;
    out.command_mm.push_back(columns.command_mm[axis][visited.first_row]);
  }
  for (double& l : distance_nm) l = std::sqrt(l);
  if (accuracy) out.ap_nm = std::sqrt(ap2_nm2);
  out.mean_l_nm = mean_of(distance_nm);
  out.s_l_nm = deviation_of(distance_nm);
  out.rp_nm = out.mean_l_nm + 3 * out.s_l_nm;
}

void rotation_figures(const PoseColumns& columns, const VisitedPose& visited, bool accuracy,
                      Iso9283Pose& out) {
  for (std::size_t i = 0; i < columns.rotations.size(); ++i) {
    const auto& measured = columns.measured_arcsec[i];
    const double command = columns.command_arcsec[i][visited.first_row];
    // About the first reading: the mean of 179.9 and -179.9 degrees is no 0.
    const double first = measured[visited.first_row];
    std::vector<double> from_first;
    for (const std::size_t row : visited.rows)
      from_first.push_back(within_half_turn(measured[row] - first));
    out.rotation_command_arcsec.push_back(command);
    out.rp_rotation_arcsec.push_back(3 * deviation_of(from_first));
    if (accuracy)
      out.ap_rotation_arcsec.push_back(within_half_turn(first + mean_of(from_first) - command));
  }
}

void worst_of_poses(Iso9283& out) {
  const auto larger = [](std::vector<double>& worst, const std::vector<double>& found) {
    worst.resize(found.size(), 0);
    for (std::size_t i = 0; i < found.size(); ++i)
      worst[i] = std::max(worst[i], std::abs(found[i]));
  };
  for (const auto& pose : out.poses) {
    if (!is_missing(pose.ap_nm))
      out.worst_ap_nm =
          is_missing(out.worst_ap_nm) ? pose.ap_nm : std::max(out.worst_ap_nm, pose.ap_nm);
    out.worst_rp_nm = std::max(out.worst_rp_nm, pose.rp_nm);
    larger(out.worst_ap_rotation_arcsec, pose.ap_rotation_arcsec);
    larger(out.worst_rp_rotation_arcsec, pose.rp_rotation_arcsec);
  }
}

}  // namespace

Result<Iso9283> iso9283(const Dataset& dataset, const Iso9283Options& options) {
  if (options.cycles < 2 || options.poses < 1)
    return fail(ErrorCode::invalid_argument, reasons::kOutOfRange,
                "expected at least 2 cycles (the standard has 30) over at least 1 pose (5)");
  DRIFTWISE_TRY(const auto columns, columns_of(dataset, options));
  auto visited = visited_poses(dataset, columns, options);
  DRIFTWISE_RETURN_IF_ERROR(check_cycles(visited, columns, options));

  Iso9283 out;
  out.axes = columns.axes;
  out.rotations = columns.rotations;
  const auto cycles = static_cast<std::size_t>(options.cycles);
  for (auto& pose : visited) {
    // The last ones: the first may have been approached from where the robot started.
    pose.rows.erase(pose.rows.begin(), pose.rows.end() - static_cast<std::ptrdiff_t>(
                                                             std::min(pose.rows.size(), cycles)));
    Iso9283Pose& figures = out.poses.emplace_back();
    figures.cycles = pose.rows.size();
    position_figures(columns, pose, options.accuracy, figures);
    rotation_figures(columns, pose, options.accuracy, figures);
  }
  worst_of_poses(out);
  out.conditions = conditions_of(dataset);
  if (options.cycles < 30 || options.poses < 5)
    out.warnings.push_back("the standard has 5 poses and 30 cycles: asked for " +
                           std::to_string(options.poses) + " and " +
                           std::to_string(options.cycles));
  if (const std::size_t datums = datum_count(dataset); datums > 1)
    out.warnings.push_back("the rows lie in " + std::to_string(datums) +
                           " datums: a new zero in between is part of the figures");
  return out;
}

}  // namespace driftwise::standards
