#pragma once
// The queue: domain -> proto; an entry that is asked for, and its change: proto -> domain.

#include "driftwise/v1/queue_service.pb.h"
#include "server/application/queue/queue.h"

namespace driftwise::rpc {

v1::QueueEntry queue_entry_from(const application::QueueLine& line, CellTime now);
v1::QueueHold queue_hold_from(const QueueHold& hold);

// Errors: invalid_argument; TOO_LONG, BAD_RULE, BAD_DURATION, BAD_ID, BAD_METADATA, BAD_NUMBER,
// EMPTY_TRAJECTORY, MODEL_WITHOUT_COMPENSATE.
Result<application::QueueDraft> queue_draft_from(const v1::AddQueueEntryRequest& request,
                                                 const RunRules& cell_rules);
Result<application::QueueEdit> queue_edit_from(const v1::ChangeQueueEntryRequest& request);

}  // namespace driftwise::rpc
