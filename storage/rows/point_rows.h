#pragma once
// Rows of datum, attempt and point with their values. Inside the caller's transaction; throws
// StorageFailure.

#include <optional>
#include <vector>

#include "server/core/records/watch_records.h"
#include "storage/sqlite/session.h"

namespace driftwise::storage {

struct FromFile {  // what an imported point keeps of its row
  std::optional<double> time_s;
  std::optional<std::int64_t> run;
};

DatumId insert_datum(Session& session, const DatumRecord& datum,
                     std::optional<std::int64_t> file_datum);
std::int64_t insert_attempt(Session& session, RunId run, const AttemptRecord& attempt);
// commanded_mm is stored as channels q1_cmd_mm, q2_cmd_mm, ... unless values has them already, or
// names the commands itself (ma.q1_cmd_mm).
PointId insert_point(Session& session, RunId run, const PointRecord& point, const FromFile& file);
// Each gets the next row after those of the plan.
void insert_passages(Session& session, RunId run, const std::vector<PointRecord>& passages);

std::vector<DatumRecord> read_datums(Session& session, RunId run);      // oldest first
std::optional<DatumRecord> read_newest_datum(Session& session);         // measured here
std::vector<AttemptRecord> read_attempts(Session& session, RunId run);  // in the order stored
// Those of a greater id, at most limit (0: all). values without the q*_cmd_mm, which become
// commanded_mm; named commands stay in values and are in commanded_mm in the order in which the
// record first had their channels.
std::vector<PointRecord> read_points(Session& session, RunId run, std::int64_t after_id, int limit);
// Of all runs, those after one id and up to another, at most limit. last: the id of the last one
// read, unchanged when there is none.
std::vector<RunAttempt> read_attempts_after(Session& session, std::int64_t after,
                                            std::int64_t until, int limit, std::int64_t& last);
std::vector<PointRecord> read_points_after(Session& session, std::int64_t after, std::int64_t until,
                                           int limit);

// "q2_cmd_mm" for axis 2; and back: 0 for any other name.
std::string commanded_channel(std::size_t axis);
std::size_t commanded_axis(std::string_view channel);

}  // namespace driftwise::storage
