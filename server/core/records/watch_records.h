#pragma once
// What somebody who watches reads: alarms, pages of the record after a cursor, series by the pixel,
// and trajectories that are kept for later.

#include <compare>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/core/records/diagnosis_records.h"
#include "server/core/records/records.h"

namespace driftwise {

struct AlarmId {
  std::int64_t value = 0;
  auto operator<=>(const AlarmId&) const = default;
};
struct TrajectoryId {
  std::int64_t value = 0;
  auto operator<=>(const TrajectoryId&) const = default;
};

enum class AlarmLevel : std::uint8_t { notice, warning, failed };
std::string_view to_string(AlarmLevel level);
std::optional<AlarmLevel> alarm_level_from(std::string_view text);

// Priority of the answer that an alarm asks for, after ISA-18.2.
enum class AlarmPriority : std::uint8_t { low, medium, high, critical };
std::string_view to_string(AlarmPriority priority);
std::optional<AlarmPriority> alarm_priority_from(std::string_view text);
// Critical: motion that nobody commanded, a stop that no controller confirmed, a motion announced,
// a limit of a user's own that says so. Else by the level: notice low, warning medium, failed high.
AlarmPriority priority_of(AlarmLevel level, std::string_view kind);
inline constexpr std::string_view kChannelLimit = "channel.limit";
inline constexpr std::string_view kCriticalChannelLimit = "channel.critical";

// States after ISA-18.2. A shelved alarm is told to nobody until its time is over.
enum class AlarmState : std::uint8_t {
  unacknowledged,
  acknowledged,
  returned_unacknowledged,
  normal,
  shelved
};
std::string_view to_string(AlarmState state);

// A condition that asks for a person. It stands from since to cleared, and stays in the list until
// it is both over and acknowledged.
struct AlarmRecord {
  AlarmId id;
  AlarmLevel level = AlarmLevel::notice;
  std::string kind;                       // dotted and stable: "device.lost", "run.waiting"
  std::string subject;                    // "laser-x", "run 17"
  std::string message;                    // a sentence
  CellTime since, cleared, acknowledged;  // utc_ns 0: not yet
  std::string acknowledged_by;
  std::vector<std::string> consequences;  // sentences: what follows from it
  std::int64_t change = 0;                // numbers every change of any alarm, for cursors
  CellTime shelved_until = {};            // utc_ns 0: not shelved
  std::string shelved_by = {}, shelve_reason = {};

  AlarmPriority priority() const { return priority_of(level, kind); }
  AlarmState state() const;
};

// An alarm set aside until an instant, by somebody, for a reason. It holds for the condition, so
// that one which returns meanwhile is shelved as well.
struct AlarmShelf {
  static constexpr double kLongest_s = 24 * 3600;
  CellTime at, until;
  std::string who, reason;
};

// A text once kept never changes.
struct KeptTrajectory {
  TrajectoryId id;
  std::string name, text, hash;
  std::int64_t rows = 0;
  CellTime created;
  std::string created_by;
};

// The last record seen, of each kind.
struct RecordCursor {
  std::int64_t event = 0, attempt = 0, point = 0, alarm = 0, model = 0, promotion = 0, job = 0;
  bool operator==(const RecordCursor&) const = default;
};

struct RunAttempt {
  RunId run;
  AttemptRecord attempt;  // without its readings
};

// Something was said of a job: made, ended; accepted or undone; a turn stored. As it is now.
struct DiagnosisChange {
  DiagnosisId id;
  JobState state = JobState::running;
  std::string reason;  // why it failed or was cancelled
};
struct ImprovementChange {
  ImprovementId id;
  JobState state = JobState::running;
  std::string reason;
  int turns = 0;  // stored so far
};

// Each list in the order in which it was stored.
struct RecordPage {
  RecordCursor to;  // the page holds everything up to here
  std::vector<EventRecord> events;
  std::vector<RunAttempt> attempts;
  std::vector<PointRecord> points;
  std::vector<AlarmRecord> alarms;  // as they are now
  std::vector<ModelId> models;
  std::vector<PromotionRecord> promotions;
  std::vector<DiagnosisChange> diagnoses;
  std::vector<ImprovementChange> improvements;
  std::vector<RunRecord> runs;  // those the page is about, as they are now
};

struct SeriesQuery {
  std::vector<std::string> channels;
  CellTime from, to;  // to is left out
  int buckets = 1;
  std::optional<RunId> run;  // the points of this run; none: the record of readings
};

struct SeriesColumn {
  std::string channel;
  std::vector<double> min, max, mean;  // per bucket; kMissing where count is 0
  std::vector<std::int64_t> count;
  bool recorded = true;  // the database has readings or points of this channel
};

// Buckets of equal length from `from` on. They may be somewhat longer than asked for, so that their
// bounds meet those of the stored summaries and every extreme stands in its own bucket.
struct SeriesAnswer {
  CellTime from, to;
  Nanoseconds bucket{};
  std::vector<SeriesColumn> columns;
};

}  // namespace driftwise
