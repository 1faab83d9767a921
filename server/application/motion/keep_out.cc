#include "server/application/motion/keep_out.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "server/core/reasons.h"

namespace driftwise::application {
namespace {

struct Distances {
  double begin_mm = 0, end_mm = 0, smallest_mm = 0;  // smallest: anywhere in the box
};

Distances distances_of(const KeepOutDescription& rule, const std::vector<Channel>& motors,
                       const std::vector<double>& from_mm, const std::vector<double>& to_mm) {
  Distances out{rule.at_zero_mm, rule.at_zero_mm, rule.at_zero_mm};
  for (const auto& term : rule.terms) {
    const auto axis =
        static_cast<std::size_t>(std::ranges::find(motors, term.axis) - motors.begin());
    if (axis >= from_mm.size() || axis >= to_mm.size()) continue;
    const double begin = term.per_mm * from_mm[axis], end = term.per_mm * to_mm[axis];
    out.begin_mm += begin;
    out.end_mm += end;
    out.smallest_mm += std::min(begin, end);
  }
  return out;
}

}  // namespace

Result<void> check_keep_out(const CellDescription& cell, const std::vector<double>& from_mm,
                            const std::vector<double>& to_mm) {
  // A sum of a few products of millimetres: far below a readback, far above its rounding.
  constexpr double kRounding_mm = 1e-9;
  const auto motors = cell.motor_channels();
  for (const auto& rule : cell.keep_outs) {
    const auto found = distances_of(rule, motors, from_mm, to_mm);
    if (found.smallest_mm >= std::min(rule.min_mm, found.begin_mm) - kRounding_mm) continue;
    const bool is_end = found.end_mm <= found.smallest_mm + kRounding_mm;
    return fail(
        ErrorCode::out_of_range, reasons::kKeepOut,
        fmt::format("robots {}: {} {:.6g} mm from each other, the keep-out rule '{}' asks for {:g} "
                    "mm at least: {}",
                    fmt::join(rule.robots, " and "),
                    is_end ? "the end of the move is"
                           : fmt::format("on the way from {:.6g} to {:.6g} mm they may come to",
                                         found.begin_mm, found.end_mm),
                    found.smallest_mm, rule.name, rule.min_mm,
                    is_end ? "stay farther away"
                           : "axes move at once; move first the robot that makes room, in a row of "
                             "its own"));
  }
  return {};
}

std::optional<std::string> first_to_move(const CellDescription& cell,
                                         const std::vector<double>& from_mm,
                                         const std::vector<double>& to_mm) {
  const auto motors = cell.motor_channels();
  for (const auto& robot : cell.robots) {
    auto between_mm = from_mm;
    for (std::size_t i = 0; i < std::min({motors.size(), from_mm.size(), to_mm.size()}); ++i)
      if (robot_of(motors[i].symbol) == robot.id) between_mm[i] = to_mm[i];
    if (check_keep_out(cell, from_mm, between_mm) && check_keep_out(cell, between_mm, to_mm))
      return robot.id;
  }
  return std::nullopt;
}

Result<void> check_homing(const CellDescription& cell, std::vector<double> from_mm) {
  std::size_t first = 0;
  for (const auto& device : cell.devices) {
    const std::size_t count = device.axes().size();
    if (count == 0) continue;
    auto to_mm = from_mm;
    for (std::size_t i = first; i < std::min(first + count, to_mm.size()); ++i) to_mm[i] = 0;
    if (auto good = check_keep_out(cell, from_mm, to_mm); !good) {
      good.error().message = fmt::format(
          "homing '{}' from where the axes stand: {}. Move the other robot to its zero first",
          device.id, good.error().message);
      return good;
    }
    from_mm = std::move(to_mm);
    first += count;
  }
  return {};
}

}  // namespace driftwise::application
