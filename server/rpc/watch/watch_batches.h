#pragma once
// What one client of Watch gets: batches of the newest states and of all records after its cursor.
// A slow client is asked for less often; of states it sees the latest, of records it misses none.

#include <memory>
#include <set>
#include <string>

#include "driftwise/v1/watch_service.pb.h"
#include "server/rpc/shared/stream.h"
#include "server/rpc/watch/watch_feed.h"

namespace driftwise::rpc {

struct WatchWish {
  std::string cursor;          // empty: from now on
  std::set<v1::Topic> topics;  // empty: all
  double max_hz = 10;
};

// Errors: invalid_argument BAD_RATE, BAD_TOPIC.
Result<WatchWish> watch_wish_from(const v1::WatchRequest& request);

// On the feed's thread. Ends with out_of_range CURSOR_TOO_OLD.
std::unique_ptr<StreamSource<v1::WatchResponse>> watch_batches(std::shared_ptr<WatchFeed> feed,
                                                               WatchWish wish);

}  // namespace driftwise::rpc
