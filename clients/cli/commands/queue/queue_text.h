#pragma once
// The queue for people, and what the command line says of times and spans.

#include <google/protobuf/duration.pb.h>
#include <google/protobuf/timestamp.pb.h>

#include <string>

#include "clients/cli/core/console.h"
#include "driftwise/v1/queue_service.pb.h"

namespace driftwise::cli {

std::string queue_state_text(v1::QueueEntry::State state);  // "set aside"
bool is_over(v1::QueueEntry::State state);                  // done, removed

// over: those that are over instead of those that wait or run.
void print_queue(const Console& console, const v1::ListQueueResponse& queue, bool over);
void print_entry(const Console& console, const v1::QueueEntry& entry);  // a line per fact

// "2026-11-22T23:00:00Z". Throws Failure (usage).
google::protobuf::Timestamp queue_instant_from(const std::string& text);
// "12h", "90min", "30 min", "45s", "2d"; "0": nothing. Throws Failure (usage).
google::protobuf::Duration queue_span_from(const std::string& text);

}  // namespace driftwise::cli
