#pragma once
// The queue of campaigns, as the store keeps it. An entry becomes a run when its turn comes.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/core/cell_time.h"
#include "server/core/ids.h"
#include "server/core/records/run_metadata.h"
#include "server/core/utc_map.h"

namespace driftwise {

enum class QueueState : std::uint8_t {
  waiting,    // for its turn, its time, another entry or a condition
  running,    // its run is under way
  following,  // its run is done, what follows from it is being made
  done,
  set_aside,  // its run failed, and the entry says to go on with the next one
  removed,    // by a person
};
constexpr bool is_over(QueueState s) { return s == QueueState::done || s == QueueState::removed; }
std::string_view to_string(QueueState state);
std::optional<QueueState> queue_state_from(std::string_view text);

enum class OnFailure : std::uint8_t { hold, set_aside };
std::string_view to_string(OnFailure rule);  // "hold", "set-aside"
std::optional<OnFailure> on_failure_from(std::string_view text);

// One of the things that follow a run that is done.
struct QueueResult {
  int position = 0;  // within QueueEntry::follow_ups, from 0
  bool good = true;
  std::string text;  // a sentence: what was made, or why it failed
  std::optional<ModelId> model{};
  std::optional<DiagnosisId> diagnosis{};
  CellTime at{};
};

struct QueueEntry {
  QueueEntryId id;
  std::int64_t place = 0;  // among entries of one priority, ascending
  QueueState state = QueueState::waiting;
  std::string reason;  // why it was set aside, put back or removed; empty: none
  std::string name, trajectory_name, trajectory_text;
  std::int64_t rows = 0;
  std::string rules_json;  // server/application/ports/run_plan.h; empty: the cell's at its start
  bool compensate = false;
  std::optional<ModelId> compensate_with;
  RunMetadata metadata;
  int priority = 0;                   // higher first
  UtcTime not_before;                 // 0: none
  std::optional<QueueEntryId> after;  // that one has to be accepted first
  std::string condition;              // server/application/queue/queue_condition.h; empty: none
  OnFailure on_failure = OnFailure::hold;
  double repeat_every_s = 0;            // from start to start; 0: once
  std::vector<std::string> follow_ups;  // server/application/queue/follow_up.h
  std::string request_id;
  CellTime created;
  std::string created_by, created_from;
  std::optional<RunId> run;  // the last one
  CellTime begun, ended;     // of that run; utc_ns 0: not yet
  std::vector<QueueResult> results;

  // Its run is done and nothing that followed failed.
  bool accepted() const {
    if (state != QueueState::done) return false;
    for (const auto& result : results)
      if (!result.good) return false;
    return true;
  }
};

// Until a person releases the queue no entry starts.
struct QueueHold {
  bool held = false;
  std::string who;  // empty: the daemon
  std::string why;  // "stopped by ada"
  CellTime at;
  bool operator==(const QueueHold&) const = default;
};

struct QueueRecord {
  std::vector<QueueEntry> entries;  // by id; texts of those that are over are blank
  QueueHold hold;
};

// Takes effect whole or not at all. Results go to the entry they stand with.
struct QueueChange {
  std::vector<QueueEntry> put = {};  // with their results; an id that is new is added
  std::optional<QueueHold> hold = {};
};

}  // namespace driftwise
