#include "server/core/trajectory/trajectory_generator.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <random>
#include <span>
#include <string>

#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise {
namespace {

struct Position {
  std::vector<double> mm;
  PointSet set = PointSet::calibration;
};

tl::unexpected<Error> bad_request(const std::string& what) {
  return fail(ErrorCode::invalid_argument, reasons::kBadPlan, what);
}

Result<void> check_axis(const GeneratorAxis& axis) {
  const std::string name = "axis " + axis.coordinate.name();
  const auto symbol = without_robot(axis.coordinate.symbol);
  if (axis.coordinate.unit != "mm" || !(is_motor_symbol(symbol) || is_pose_symbol(symbol)))
    return bad_request(
        name +
        ": expected a motor coordinate such as q1_mm or a pose in mm, x_mm, with the "
        "robot's id before it in a cell of several robots: ma.q1_mm");
  if (!std::isfinite(axis.from_mm) || !std::isfinite(axis.to_mm) || axis.to_mm < axis.from_mm)
    return bad_request(name + ": expected finite from_mm and to_mm, from_mm not above to_mm");
  if (axis.count < 1 || axis.count > 10'000 || (axis.count > 1 && axis.to_mm == axis.from_mm))
    return bad_request(name + ": count: found " + std::to_string(axis.count) +
                       ", expected 1 to 10 000 different positions");
  return {};
}

Result<void> check_plan(const GeneratorPlan& plan) {
  if (plan.axes.empty() || plan.axes.size() > 6)
    return bad_request("axes: found " + std::to_string(plan.axes.size()) + ", expected 1 to 6");
  for (std::size_t i = 0; i < plan.axes.size(); ++i) {
    if (auto good = check_axis(plan.axes[i]); !good) return good;
    for (std::size_t k = 0; k < i; ++k)
      if (plan.axes[k].coordinate == plan.axes[i].coordinate)
        return bad_request("axes: " + plan.axes[i].coordinate.name() + " is named twice");
  }
  if (plan.line_length < 0) return bad_request("line_length: expected 0 or more");
  if (plan.repeats < 1 || plan.repeats > 1000)
    return bad_request("repeat_count: expected 1 to 1000");
  for (const double force : plan.forces_n)
    if (!std::isfinite(force)) return bad_request("forces_n: expected finite numbers");
  return {};
}

// Before anything is made: a typo must not cost the memory of a billion rows.
Result<void> check_row_count(const GeneratorPlan& plan) {
  double cells = 1, middles = 1;
  for (const auto& axis : plan.axes) {
    cells *= static_cast<double>(axis.count);
    middles *= static_cast<double>(std::max<std::int64_t>(axis.count - 1, 1));
  }
  const double passes =
      static_cast<double>(plan.repeats) * std::max(1.0, static_cast<double>(plan.forces_n.size()));
  const double rows = passes * (cells + (plan.with_validation ? middles : 0));
  if (rows > static_cast<double>(kMostGeneratedRows))
    return fail(ErrorCode::resource_exhausted, reasons::kTooManyRows,
                "the plan has about " + std::to_string(std::llround(std::min(rows, 1e15))) +
                    " points, at most 200 000 are made: ask for fewer positions, forces or "
                    "repeats");
  return {};
}

double to_picometres(double mm) { return std::round(mm * 1e9) / 1e9; }

double level_mm(const GeneratorAxis& axis, double i) {
  const double step =
      axis.count > 1 ? (axis.to_mm - axis.from_mm) / static_cast<double>(axis.count - 1) : 0;
  return to_picometres(axis.from_mm + i * step);
}

// All positions of a grid, the first axis fastest; shift 0.5: the middles of its cells.
std::vector<Position> grid_of(const GeneratorPlan& plan, double shift, PointSet set) {
  std::vector<Position> out;
  std::vector<std::int64_t> at(plan.axes.size(), 0);
  const auto levels = [&](std::size_t i) {
    return shift == 0 ? plan.axes[i].count : std::max<std::int64_t>(plan.axes[i].count - 1, 1);
  };
  for (bool done = false; !done;) {
    Position position{{}, set};
    for (std::size_t i = 0; i < at.size(); ++i)
      position.mm.push_back(level_mm(plan.axes[i], static_cast<double>(at[i]) + shift));
    out.push_back(std::move(position));
    done = true;
    for (std::size_t i = 0; i < at.size() && done; ++i) {
      done = ++at[i] == levels(i);
      if (done) at[i] = 0;
    }
  }
  return out;
}

std::vector<Position> pass_of(const GeneratorPlan& plan) {
  const auto grid = grid_of(plan, 0, PointSet::calibration);
  if (!plan.with_validation) return grid;
  const auto middles = grid_of(plan, 0.5, PointSet::validation);
  const auto line = static_cast<std::size_t>(plan.axes.front().count);
  const std::size_t beside = std::max<std::size_t>(line - 1, 1);
  std::vector<Position> out;
  std::size_t next = 0;
  for (std::size_t i = 0; i < grid.size(); ++i) {
    out.push_back(grid[i]);
    if ((i + 1) % line != 0) continue;
    const std::size_t end = std::min(next + beside, middles.size());
    for (; next < end; ++next) out.push_back(middles[next]);
  }
  out.insert(out.end(), middles.begin() + static_cast<std::ptrdiff_t>(next), middles.end());
  return out;
}

// The same on every machine, which std::shuffle is not.
void shuffle(std::vector<Position>& positions, std::mt19937_64& random) {
  for (std::size_t i = positions.size(); i > 1; --i)
    std::swap(positions[i - 1], positions[static_cast<std::size_t>(random() % i)]);
}

void append_pass(std::span<const Position> positions, std::size_t line_length,
                 std::optional<double> force_n, Trajectory& out, std::int64_t& line) {
  const auto point = [&](std::vector<double> mm, PointSet set, bool zero) {
    TrajectoryPoint row;
    row.target = std::move(mm);
    row.set = set;
    row.line = line;
    row.zero = zero;
    row.force_n = force_n;
    out.points.push_back(std::move(row));
  };
  for (std::size_t i = 0; i < positions.size(); ++i) {
    point(positions[i].mm, positions[i].set, false);
    if ((i + 1) % line_length != 0 && i + 1 != positions.size()) continue;
    point(std::vector<double>(out.coordinates.size(), 0.0), PointSet::calibration, true);
    ++line;
  }
}

struct Stretch {  // of one force
  std::optional<double> force_n;
  std::vector<Position> positions;
};

// Every pass under each force. In a random order a force must not rise with time either, or a fit
// takes the room's warming for force: each pass is cut in two, and the second halves come with the
// forces in reverse, f1 f2 f3 f3 f2 f1, so that force and time do not correlate (a foldover: Box,
// Hunter and Hunter, Statistics for Experimenters, 2nd ed., section 6.3).
std::vector<Stretch> stretches_of(const GeneratorPlan& plan) {
  std::vector<std::optional<double>> forces(plan.forces_n.begin(), plan.forces_n.end());
  if (forces.empty()) forces.push_back(std::nullopt);
  std::mt19937_64 random(plan.shuffle_seed.value_or(0));
  bool backwards = false;
  const auto pass = [&] {
    auto positions = pass_of(plan);
    if (plan.shuffle_seed) shuffle(positions, random);
    if (backwards) std::reverse(positions.begin(), positions.end());
    backwards = plan.both_directions && !backwards;
    return positions;
  };
  std::vector<Stretch> all;
  if (!plan.shuffle_seed || forces.size() == 1) {
    for (const auto& force : forces)
      for (std::int64_t repeat = 0; repeat < plan.repeats; ++repeat) all.push_back({force, pass()});
    return all;
  }
  for (std::int64_t repeat = 0; repeat < plan.repeats; ++repeat) {
    std::vector<Stretch> second;
    for (const auto& force : forces) {
      auto first = pass();
      const auto middle = first.begin() + static_cast<std::ptrdiff_t>((first.size() + 1) / 2);
      if (middle != first.end()) second.push_back({force, {middle, first.end()}});
      first.erase(middle, first.end());
      all.push_back({force, std::move(first)});
    }
    all.insert(all.end(), std::make_move_iterator(second.rbegin()),
               std::make_move_iterator(second.rend()));
  }
  return all;
}

}  // namespace

Result<Trajectory> generate_trajectory(const GeneratorPlan& plan) {
  DRIFTWISE_RETURN_IF_ERROR(check_plan(plan));
  DRIFTWISE_RETURN_IF_ERROR(check_row_count(plan));
  Trajectory out;
  for (const auto& axis : plan.axes) out.coordinates.push_back(axis.coordinate);
  const std::size_t line_length =
      static_cast<std::size_t>(plan.line_length > 0 ? plan.line_length : plan.axes.front().count);
  std::int64_t line = 0;
  for (const auto& stretch : stretches_of(plan))
    append_pass(stretch.positions, line_length, stretch.force_n, out, line);
  if (static_cast<std::int64_t>(out.points.size()) > kMostGeneratedRows)
    return fail(ErrorCode::resource_exhausted, reasons::kTooManyRows,
                "with its returns to zero the plan has " + std::to_string(out.points.size()) +
                    " rows, at most 200 000 are made: ask for longer lines or fewer positions");
  return out;
}

}  // namespace driftwise
