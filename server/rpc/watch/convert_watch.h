#pragma once
// What a watch sends: domain -> proto. Layout, values, alarms, pages of the record, series.

#include <vector>

#include "driftwise/v1/watch_service.pb.h"
#include "server/application/diagnoses/diagnosis_progress.h"
#include "server/application/improvement/improvements.h"
#include "server/application/notify/notifications.h"
#include "server/application/status/cell_status.h"
#include "server/core/records/watch_records.h"

namespace driftwise::rpc {

v1::Alarm alarm_from(const AlarmRecord& alarm);
v1::Receiver receiver_from(const application::ReceiverStatus& receiver);
v1::Telling telling_from(const TellingRecord& telling);

// Every channel of status.values, in that order; revision is left for the caller.
v1::ChannelLayout layout_from(const application::CellStatus& status);
// In the same order.
v1::ValuesUpdate values_update_from(const application::CellStatus& status);

// The page's records in the order of their kinds: models, promotions, events, runs, attempts,
// points, alarms, diagnoses, improvements.
std::vector<v1::WatchEvent> watch_events_from(const RecordPage& page);
v1::Topic topic_of(const v1::WatchEvent& event);

// base: the first value there is, so that floats resolve the rest.
v1::Series series_from(const SeriesColumn& column);

}  // namespace driftwise::rpc
