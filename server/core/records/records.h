#pragma once
// What the store keeps, as values. DESIGN words: run, datum, point, attempt, move, model, event.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/core/cell_time.h"
#include "server/core/data/judged_reading.h"
#include "server/core/data/reading.h"
#include "server/core/ids.h"
#include "server/core/records/run_metadata.h"
#include "server/core/trajectory/trajectory.h"

namespace driftwise {

enum class RunState : std::uint8_t { queued, running, paused, waiting, done, aborted, failed };
constexpr bool is_over(RunState s) {
  return s == RunState::done || s == RunState::aborted || s == RunState::failed;
}
std::string_view to_string(RunState state);
std::optional<RunState> run_state_from(std::string_view text);

// Where a run stands in its trajectory. Rows before next_row are decided (accepted or given up)
// unless they stand in requeued; those are visited again, in this order, at the end of the line
// they belong to.
struct Requeued {
  std::int64_t row = 0;
  int count = 1;
  bool operator==(const Requeued&) const = default;
};
struct Place {
  std::int64_t next_row = 0;
  std::vector<Requeued> requeued;
  bool operator==(const Place&) const = default;
};

struct NewRun {
  std::string name;
  std::string trajectory_name, trajectory_text;  // as given: the run's record is complete by itself
  std::int64_t rows = 0;
  std::string rules_json;  // RunRules as used
  std::string config_hash, config_text;
  std::string operator_name;
  std::string request_id;  // empty: none. The same id again answers with the first run
  Stamp created;
  std::string boot_id = {};  // of this start of the computer; empty: not known
  RunMetadata metadata = {};
  std::optional<QueueEntryId> queue_entry = {};  // becomes running with it
};

// What a run stands for until a person ends it. Its instant is its identity: who resumes the run,
// or moves the axes meanwhile, names it.
struct RunHold {
  enum class Kind : std::uint8_t {
    none,           // the run does not stand
    pause,          // a person paused it
    stop,           // a person stopped the axes
    trouble,        // the daemon asks for a person
    restart,        // the daemon or the computer was away, and the cell file says to wait
    configuration,  // the cell file has changed: whoever accepts it ends this too
    condition,      // of the cell ([[hold]]): ends by itself, and is looked at anew after a restart
  };
  Kind kind = Kind::none;
  std::string who;  // of a pause or a stop, as stated
  CellTime at;
  std::string reason;  // "paused by ada"
  std::int64_t id() const { return at.utc_ns; }
  bool operator==(const RunHold&) const = default;
};
std::string_view to_string(RunHold::Kind kind);
std::optional<RunHold::Kind> hold_kind_from(std::string_view text);

struct RunRecord {
  RunId id;
  std::string name, trajectory_name, trajectory_text;
  std::int64_t rows = 0;
  std::string rules_json;
  std::string config_hash;  // empty: its rows are a file's, which this cell did not measure
  std::string operator_name, request_id;
  RunState state = RunState::queued;
  std::string reason;                // why it is in this state: "paused by ada", "E-stop: ..."
  CellTime created, started, ended;  // utc_ns 0: not yet
  Place place;
  std::int64_t accepted = 0, given_up = 0, attempts = 0, restarts = 0;
  double max_lag_s = 0;  // largest lag in cell seconds
  RunHold hold;
  std::string boot_id;  // of the computer when the run last changed its state; empty: not known
  RunMetadata metadata;
  std::optional<QueueEntryId> queue_entry;  // that began it
};

// Its rows are a file's: their instruments and thermometers are not known to be this cell's.
inline bool is_of_file(const RunRecord& run) { return run.config_hash.empty(); }

struct RunChange {  // what is set is changed
  std::optional<RunState> state;
  std::optional<std::string> reason;
  std::optional<CellTime> started, ended;
  std::optional<double> max_lag_s;
  std::optional<std::int64_t> restarts;
  std::optional<RunHold> hold;
  std::optional<std::string> boot_id;
};

// One stretch of data between two zeroings, with all temperatures at that instant.
struct DatumRecord {
  DatumId id;
  std::optional<RunId> run;
  Stamp opened;
  std::string reason;                // "start", "restart after a kill", "beam lost", "operator"
  std::vector<ChannelValue> values;  // zero readings (q, x) before zeroing and every temperature
};

enum class Verdict : std::uint8_t { accepted, reread, reapproach, requeued, given_up, interrupted };
std::string_view to_string(Verdict verdict);

// One try at a point, kept whatever came of it.
struct AttemptRecord {
  std::int64_t row = 0;
  int number = 1;  // counts this row's attempts within the run, from 1
  Verdict verdict = Verdict::accepted;
  std::string reason;  // empty when accepted: "spread 7.3 nm of 4 readings, limit 5 nm"
  Stamp started, ended;
  double spread_nm = kMissing;
  std::vector<Reading> readings;  // those it consists of (interferometers, readback)
};

struct PointRecord {
  PointId id;
  RunId run;
  std::int64_t row = 0;
  DatumId datum;
  PointSet set = PointSet::calibration;
  std::int64_t line = 0;
  bool zero = false;
  // The run came by beside its plan (docs/formats.md); row is then a number after those of the
  // plan.
  bool passage = false;
  Stamp measured;                    // middle of its readings
  double dwell_s = 0;                // between the end of the move and the measurement
  std::vector<double> commanded_mm;  // motor coordinates, in order of the axes
  std::vector<ChannelValue> values;  // joined: means of the readings, x_std_nm, temperatures, ...
};

struct MoveRecord {
  std::optional<RunId> run;
  Stamp at;
  std::vector<double> from_mm, to_mm;
  std::string cause;
};

// Everything that one accepted (or given up) point changes, in one transaction.
struct PointCommit {
  RunId run;
  std::vector<AttemptRecord> attempts;  // those not stored yet, the last one decides
  std::optional<PointRecord> point;     // none when the row was given up or queued again
  std::vector<Reading> slow_readings;   // the recorder's, waiting to be stored
  std::vector<MoveRecord> moves;
  Place place;                                // where the run stands after this
  std::vector<RejectedAnswer> rejected = {};  // of any readings, waiting to be stored
  std::vector<PointRecord> passages = {};     // before the point, oldest first; the store sets row
};

struct EventRecord {
  EventId id;
  Stamp at;
  std::string who;     // operator's name, "daemon"
  std::string from;    // peer address, empty for the daemon
  std::string what;    // dotted and stable: "run.started", "lease.taken", "device.lost"
  std::string detail;  // a sentence
  std::optional<RunId> run;
};

// Rows of a run kept out of fits, or put back. Records only ever add up: the last word on a row
// counts, the points themselves are never touched.
struct ExclusionRecord {
  std::int64_t id = 0;
  RunId run;
  bool excluded = true;            // false: put back
  std::vector<std::int64_t> rows;  // of the trajectory, ascending, each once
  std::string reason;
  Stamp at;
  std::string who, from;  // as in EventRecord
  bool suspect = false;   // the daemon's mark: points that rest on a false instrument or zero
};

// What a note is on: a run, a point of it, or a model.
struct NoteSubject {
  std::optional<RunId> run;
  std::optional<std::int64_t> row;  // with a run
  std::optional<ModelId> model;
};
struct NoteRecord {
  std::int64_t id = 0;
  NoteSubject on;
  std::string text;
  Stamp at;
  std::string who, from;
};

// A remark on an instant, kept for ever.
struct TimeNoteRecord {
  std::int64_t id = 0;
  CellTime about;  // the instant
  std::string text;
  std::string channel;  // empty: the cell
  std::string request;  // of whoever asked: the same again is the first note; empty: none
  Stamp at;             // when it was written
  std::string who, from;
};

struct ModelRecord {
  ModelId id;
  std::string name;
  std::string json;  // driftwise.model.v1: the model whole
  std::string hash;  // of the json
  std::optional<ModelId> parent;
  CellTime created;
  std::string created_by, note;
  // In force over its data when it was fitted, ascending; ended since or not.
  std::vector<CorrectionId> corrections{};
  // What is wrong with it, a sentence; then the other fields hold what could be read. Not stored.
  std::string damage = {};
};

struct PromotionRecord {
  std::optional<ModelId> model;
  CellTime at;
  std::string by;
  std::string action;
};  // promote | rollback

}  // namespace driftwise
