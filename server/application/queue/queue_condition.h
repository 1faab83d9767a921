#pragma once
// What an entry of the queue waits for in the cell's own values. Pure.
//
//   t12 < 20.5 degC                   the newest value is below
//   t12 < 20.5 degC for 30 min        every recorded value of the last 30 min is below, and the
//                                     newest one
//   t12 > 20.5 degC for 2 h           likewise above
//   t12 lowest of 24 h within 0.1 degC  the newest value is at most 0.1 degC above the lowest value
//                                     recorded in the last 24 h, of which nine tenths are recorded
//   t12 coldest within 0.1 degC       the same with 24 h
//
// A record with a gap, or a newest value that is too old, does not meet a condition.

#include <string>
#include <string_view>
#include <vector>

#include "server/core/cell_time.h"
#include "server/core/channel.h"
#include "server/core/description/cell_description.h"
#include "server/core/records/watch_records.h"
#include "server/core/result.h"

namespace driftwise::application {

struct QueueCondition {
  enum class Kind { below, above, lowest };
  Kind kind = Kind::below;
  Channel channel;
  double value = 0;   // the limit; of lowest: the tolerance
  double span_s = 0;  // how long; of lowest: how far back; 0: now
};

// Channels of a cell that a condition can name: what its devices record.
std::vector<Channel> channels_for_conditions(const CellDescription& description);

// Errors: invalid_argument BAD_CONDITION: what was found, and how one is written.
Result<QueueCondition> parse_condition(std::string_view text, const std::vector<Channel>& channels);
// As parse_condition reads it.
std::string to_string(const QueueCondition& condition);
// "30 min", "1.5 h", "45 s".
std::string span_text(double seconds);

// What is known of the condition's channel.
struct ConditionRecord {
  double newest = kMissing;
  double age_s = 0;        // of the newest
  SeriesAnswer series;     // over the span; no columns: nothing is recorded
  double most_age_s = 60;  // an older newest value says nothing
};
// Buckets for a query over the span.
int buckets_for(const QueueCondition& condition);

struct ConditionVerdict {
  bool met = false;
  std::string sentence;  // "t12_degC below 20.5 degC for 30 min: 21.3 now"
};
ConditionVerdict judge(const QueueCondition& condition, const ConditionRecord& record,
                       CellTime now);

}  // namespace driftwise::application
