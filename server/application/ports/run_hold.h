#pragma once
// Who may end what a run stands for. Pure.
//
// Until identities are proved a name is a statement of the client: this keeps people from starting
// a robot by mistake. It is no lock-out, and does not replace one.

#include <string>

#include "server/core/records/records.h"
#include "server/core/result.h"

namespace driftwise::application {

// What a person says who resumes a run that stands, or who moves the axes meanwhile.
struct HoldAnswer {
  std::int64_t hold_id = 0;     // RunHold::id() of what he saw; 0: not said
  std::string override_reason;  // why another one than the one who stopped may go on
};

// "run 3 was stopped by ada 12 min ago (stopped by ada)".
std::string hold_sentence(const RunRecord& run, const RunHold& hold, CellTime now);

// What a run stands for that was stored as paused. A database without it, or a daemon that was
// killed between the stop and its writing, leaves the reason alone: "stopped by ada".
RunHold stored_hold(const RunRecord& run, CellTime now);

// Errors, failed_precondition: NOT_PAUSED (the run does not stand); HELD_BY_CELL (it waits for a
// [[hold]], which ends by itself); HOLD_NOT_NAMED (another pause
// or stop is in force than the one named, or none is named); STOPPED_BY_ANOTHER (a person's stop,
// another name, no reason in writing). Each says who paused, and how long ago.
Result<void> check_answer(const RunRecord& run, const RunHold& hold, const std::string& name,
                          const HoldAnswer& answer, CellTime now);

}  // namespace driftwise::application
