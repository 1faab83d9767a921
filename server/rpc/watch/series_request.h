#pragma once
// GetSeriesRequest -> SeriesQuery, with what is left out filled in.

#include "driftwise/v1/watch_service.pb.h"
#include "server/application/ports/host.h"
#include "server/application/runs/runs.h"
#include "server/core/records/watch_records.h"

namespace driftwise::rpc {

// to: now when absent; with a run that is over, its end. from: the run's start, else one hour
// before to. Errors: invalid_argument BAD_CHANNEL (naming it), BAD_BUCKETS, BAD_RANGE, BAD_TIME,
// BAD_ID; resource_exhausted TOO_MANY_BUCKETS; not_found NO_SUCH_RUN.
Awaitable<Result<SeriesQuery>> series_query_from(const v1::GetSeriesRequest& request,
                                                 const application::Host& host,
                                                 application::Runs& runs);

}  // namespace driftwise::rpc
