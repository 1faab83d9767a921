#include "server/application/runs/trajectory_walk.h"

#include <algorithm>

namespace driftwise::application {
namespace {

const TrajectoryPoint& point(const Trajectory& trajectory, std::int64_t row) {
  return trajectory.points[static_cast<std::size_t>(row)];
}
std::int64_t size(const Trajectory& trajectory) {
  return static_cast<std::int64_t>(trajectory.points.size());
}

}  // namespace

std::optional<Visit> next_visit(const Trajectory& trajectory, const Place& place) {
  const bool rows_left = place.next_row < size(trajectory);
  if (!place.requeued.empty()) {
    const auto& queued = place.requeued.front();
    const bool line_is_over =
        !rows_left || point(trajectory, place.next_row).line != point(trajectory, queued.row).line;
    if (line_is_over) return Visit{queued.row, queued.count, true};
  }
  if (rows_left) return Visit{place.next_row, 0, false};
  return std::nullopt;
}

Place place_after(Place place, const Visit& visit, Verdict verdict) {
  if (verdict != Verdict::accepted && verdict != Verdict::requeued && verdict != Verdict::given_up)
    return place;
  if (visit.from_queue)
    place.requeued.erase(place.requeued.begin());
  else
    ++place.next_row;
  if (verdict == Verdict::requeued) place.requeued.push_back({visit.row, visit.requeues + 1});
  return place;
}

bool return_to_zero_is_due(const Trajectory& trajectory, const Place& place,
                           std::int64_t visited_row) {
  const auto line = point(trajectory, visited_row).line;
  const auto next = next_visit(trajectory, place);
  if (next && point(trajectory, next->row).line == line) return false;
  if (next && point(trajectory, next->row).zero) return false;
  std::int64_t row = visited_row;
  while (row > 0 && point(trajectory, row - 1).line == line) --row;
  for (; row < size(trajectory) && point(trajectory, row).line == line; ++row)
    if (point(trajectory, row).zero) return false;
  return true;
}

void SinceReturn::begin(const Place& place, std::int64_t given_up_so_far) {
  first_row = place.next_row;
  given_up = given_up_so_far;
  rows.clear();
  returned = false;
}

void SinceReturn::add(std::int64_t row, Verdict verdict) {
  if (verdict != Verdict::accepted && verdict != Verdict::given_up) return;
  rows[row] = verdict == Verdict::accepted;
  last_row = row;
  returned = false;
}

std::int64_t SinceReturn::accepted() const {
  return std::ranges::count_if(rows, [](const auto& row) { return row.second; });
}

bool return_to_zero_is_owed(const Trajectory& trajectory, const Place& place,
                            const SinceReturn& since) {
  return !since.rows.empty() && !since.returned &&
         return_to_zero_is_due(trajectory, place, since.last_row);
}

RepeatedLine repeat_since(const SinceReturn& since, const Place& place, std::int64_t given_up) {
  RepeatedLine line;
  line.given_up = given_up - since.given_up;
  line.place.next_row = std::min(since.first_row, place.next_row);
  for (const auto& queued : place.requeued)
    if (queued.row < line.place.next_row) line.place.requeued.push_back(queued);
  for (const auto& [row, accepted] : since.rows) {
    if (accepted) line.rows.push_back(row);
    if (row < line.place.next_row) line.place.requeued.push_back({row, 1});
  }
  return line;
}

std::int64_t visits_left(const Trajectory& trajectory, const Place& place) {
  return size(trajectory) - place.next_row + static_cast<std::int64_t>(place.requeued.size());
}

}  // namespace driftwise::application
