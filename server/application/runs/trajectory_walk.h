#pragma once
// Where a run goes next in its trajectory. Pure arithmetic over Place
// (server/core/records/records.h).

#include <cstdint>
#include <map>
#include <optional>

#include "server/core/records/closure_records.h"
#include "server/core/records/records.h"
#include "server/core/trajectory/trajectory.h"

namespace driftwise::application {

struct Visit {
  std::int64_t row = 0;
  int requeues = 0;  // how often this row has been queued again already
  bool from_queue = false;
};

// None: the run is complete. Queued rows come at the end of the line they belong to, in their
// order.
std::optional<Visit> next_visit(const Trajectory& trajectory, const Place& place);

// The place after a visit that ended with accepted, requeued or given_up. Other verdicts leave it
// as it is.
Place place_after(Place place, const Visit& visit, Verdict verdict);

// True when the visit that led to this place was the last of its line, the line had no zero row of
// its own and the next row is none either: the axis then returns to zero by itself, so that the
// drift is known.
bool return_to_zero_is_due(const Trajectory& trajectory, const Place& place,
                           std::int64_t visited_row);

// What was measured since a return to zero was judged, or a datum was opened.
struct SinceReturn {
  std::int64_t first_row = 0;           // the run's next row then
  std::int64_t given_up = 0;            // of the run then
  std::map<std::int64_t, bool> rows{};  // decided since: accepted, or given up
  std::int64_t last_row = 0;            // decided last
  bool returned = false;                // to the zero since then, whatever was found there
  void begin(const Place& place, std::int64_t given_up_so_far);
  void add(std::int64_t row, Verdict verdict);
  std::int64_t accepted() const;
};

// By what is known, not by what was done last: a return that was interrupted stays owed. Its line
// is that of the row decided last.
bool return_to_zero_is_owed(const Trajectory& trajectory, const Place& place,
                            const SinceReturn& since);

// All of it is visited again: the rows from the first one on by walking, those that were queued
// before it from the queue. given_up: of the run now.
RepeatedLine repeat_since(const SinceReturn& since, const Place& place, std::int64_t given_up);

// Visits still ahead: rows not visited yet and those queued again.
std::int64_t visits_left(const Trajectory& trajectory, const Place& place);

}  // namespace driftwise::application
