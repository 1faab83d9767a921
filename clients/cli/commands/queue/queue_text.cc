#include "clients/cli/commands/queue/queue_text.h"

#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "clients/cli/pages/band_text.h"
#include "clients/cli/pages/metadata_text.h"
#include "server/core/cell_time.h"

namespace driftwise::cli {

std::string queue_state_text(v1::QueueEntry::State state) {
  switch (state) {
    case v1::QueueEntry::STATE_WAITING:
      return "waiting";
    case v1::QueueEntry::STATE_RUNNING:
      return "running";
    case v1::QueueEntry::STATE_FOLLOWING:
      return "following";
    case v1::QueueEntry::STATE_DONE:
      return "done";
    case v1::QueueEntry::STATE_SET_ASIDE:
      return "set aside";
    case v1::QueueEntry::STATE_REMOVED:
      return "removed";
    default:
      return "unknown";
  }
}

bool is_over(v1::QueueEntry::State state) {
  return state == v1::QueueEntry::STATE_DONE || state == v1::QueueEntry::STATE_REMOVED;
}

namespace {

// "Sun 14:10, 80 %: 13:50 to 14:40"; where that hangs on more than its turn: how long it takes.
std::string ends(const v1::QueueEntry& entry) {
  if (entry.has_latest_end_time())
    return end_text(entry.estimated_end_time(), entry.earliest_end_time(), entry.latest_end_time(),
                    entry.estimated_band().share());
  if (entry.has_estimated_duration())
    return "takes " + span_text(seconds_of(entry.estimated_duration()));
  return "-";
}

}  // namespace

void print_queue(const Console& console, const v1::ListQueueResponse& queue, bool over) {
  const Paint paint = console.paint_out();
  if (queue.has_hold() && !over)
    console.out << paint.warn("the queue is held: " + queue.hold().why()) << " (since "
                << clock_text(queue.hold().begin_time())
                << " UTC): `driftwise queue release` lets entries start\n\n";
  Table table({{"entry", Align::right},
               {"name"},
               {"state"},
               {"priority", Align::right},
               {"rows", Align::right},
               {"run", Align::right},
               {"by"},
               {over ? "ended (UTC)" : "ends (UTC)"},
               {"metadata"},
               {over ? "what came of it" : "why it waits"}});
  for (const auto& entry : queue.entries()) {
    if (is_over(entry.state()) != over) continue;
    std::string why = entry.waits_for();
    if (!entry.reason().empty()) why += (why.empty() ? "" : "; before: ") + entry.reason();
    for (const auto& result : entry.results()) why += (why.empty() ? "" : "; ") + result.text();
    table.add({std::to_string(entry.id()), entry.name(), queue_state_text(entry.state()),
               std::to_string(entry.priority()), std::to_string(entry.row_count()),
               entry.has_run_id() ? std::to_string(entry.run_id()) : "-", entry.created_by(),
               over ? (entry.has_end_time() ? clock_text(entry.end_time()) : "-") : ends(entry),
               metadata_text(entry.metadata()), why});
  }
  if (table.empty())
    console.out << (over ? "no entry is over yet\n"
                         : "the queue is empty: driftwise queue add PLAN.csv\n");
  else
    table.print(console.out, paint);
}

void print_entry(const Console& console, const v1::QueueEntry& entry) {
  const Paint paint = console.paint_out();
  const auto line = [&](const std::string& name, const std::string& value) {
    console.out << paint.dim(name + std::string(name.size() < 14 ? 14 - name.size() : 1, ' '))
                << value << '\n';
  };
  line("entry", std::to_string(entry.id()) + "  " + entry.name());
  line("state", queue_state_text(entry.state()) +
                    (entry.reason().empty() ? "" : "  (" + entry.reason() + ")"));
  if (!entry.waits_for().empty()) line("now", entry.waits_for());
  line("trajectory", entry.trajectory_name() + ", " + std::to_string(entry.row_count()) + " rows");
  if (!entry.setup().empty()) line("set-up", entry.setup());
  if (entry.compensate())
    line("compensation", entry.has_compensate_model_id()
                             ? "model " + std::to_string(entry.compensate_model_id())
                             : "the model that serves then");
  line("priority", std::to_string(entry.priority()));
  if (entry.has_not_before_time()) line("not before", clock_text(entry.not_before_time()) + " UTC");
  if (entry.has_after_entry_id())
    line("after", "entry " + std::to_string(entry.after_entry_id()) + ", when it was accepted");
  if (!entry.condition().empty()) line("when", entry.condition());
  line("on failure", entry.set_aside_on_failure() ? "it is set aside, the next one starts"
                                                  : "back in front, and the queue is held");
  if (entry.has_repeat_duration())
    line("repeated", "every " + span_text(seconds_of(entry.repeat_duration())));
  for (const auto& follow_up : entry.follow_ups()) line("then", follow_up);
  if (!entry.metadata().empty()) line("metadata", metadata_text(entry.metadata()));
  line("added", clock_text(entry.create_time()) + " UTC by " + entry.created_by());
  if (entry.has_estimated_duration() && !is_over(entry.state()))
    line("takes", span_text(seconds_of(entry.estimated_duration())) + " of cell time (" +
                      band_text(entry.estimated_band()) + ")");
  if (entry.has_latest_end_time()) line("ends", ends(entry) + " UTC");
  if (entry.has_run_id()) line("run", std::to_string(entry.run_id()));
  for (const auto& result : entry.results())
    line(result.good() ? "result" : "failed", result.follow_up() + ": " + result.text());
}

google::protobuf::Timestamp queue_instant_from(const std::string& text) {
  const auto time = parse_iso8601(text);
  if (!time)
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  "--not-before: found '" + text + "', expected UTC as 2026-11-22T23:00:00Z"};
  google::protobuf::Timestamp out;
  out.set_seconds(time->utc_ns / 1'000'000'000);
  out.set_nanos(static_cast<std::int32_t>(time->utc_ns % 1'000'000'000));
  return out;
}

google::protobuf::Duration queue_span_from(const std::string& text) {
  const auto end = text.find_first_not_of("0123456789.");
  const auto number = number_from(text.substr(0, end));
  std::string unit = end == std::string::npos ? "" : text.substr(end);
  while (unit.starts_with(' ')) unit.erase(0, 1);
  const double factor = unit == "s"     ? 1
                        : unit == "min" ? 60
                        : unit == "h"   ? 3600
                        : unit == "d"   ? 86'400
                                        : 0;
  const bool is_none = text == "0";
  constexpr double kMost_s = 366 * 86'400.0;
  if (!number || (factor == 0 && !is_none) || *number * factor > kMost_s)
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  "--repeat-every: found '" + text +
                      "', expected a number with s, min, h or d (12h), at most 366 d; 0: once"};
  google::protobuf::Duration out;
  out.set_seconds(static_cast<std::int64_t>(*number * factor));
  return out;
}

}  // namespace driftwise::cli
