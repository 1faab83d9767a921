#include "clients/cli/commands/queue/queue_commands.h"

#include <memory>

#include "clients/cli/commands/queue/queue_text.h"
#include "clients/cli/commands/runs/report_command.h"
#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/validators.h"
#include "clients/cli/pages/metadata_text.h"
#include "driftwise/v1/queue_service.grpc.pb.h"
#include "driftwise/v1/trajectory_service.grpc.pb.h"

namespace driftwise::cli {
namespace {

using QueueStub = v1::QueueService::Stub;

struct QueueArguments {
  std::string file, name, setup, not_before, when, on_failure, repeat_every, request_id, reason;
  std::vector<std::string> then, meta, remove_meta;
  std::int64_t id = 0, after = 0, model = 0, trajectory = 0, before = 0;
  std::int32_t priority = 0;
  bool compensate = false, front = false, back = false;
  // Which options were given.
  CLI::Option *has_priority = nullptr, *has_after = nullptr, *has_when = nullptr;
};

ExitCode show_entry(const Session& session, const v1::QueueEntry& entry) {
  if (session.console.json)
    session.console.print_json(json_from(entry));
  else
    print_entry(session.console, entry);
  return ExitCode::done;
}

// The text of a file, or of a trajectory that the daemon keeps.
void take_trajectory(const Connection& connection, const QueueArguments& a,
                     v1::AddQueueEntryRequest& request) {
  if (a.trajectory == 0) {
    request.set_trajectory_name(base_name(a.file));
    request.set_trajectory_text(read_input_file(a.file));
    return;
  }
  v1::GetTrajectoryRequest wanted;
  wanted.set_trajectory_id(a.trajectory);
  const auto kept =
      connection.ask(&v1::TrajectoryService::Stub::GetTrajectory, wanted).trajectory();
  request.set_trajectory_name(kept.name());
  request.set_trajectory_text(kept.text());
}

ExitCode add_entry(const Session& session, const QueueArguments& a) {
  if (a.file.empty() == (a.trajectory == 0))
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  "queue add needs a trajectory: a file, or --trajectory with the number of a kept "
                  "one"};
  v1::AddQueueEntryRequest request;
  request.set_name(a.name);
  request.set_setup(a.setup);
  request.set_compensate(a.compensate);
  if (a.model != 0) request.set_compensate_model_id(a.model);
  for (auto& item : metadata_from(a.meta)) *request.add_metadata() = std::move(item);
  request.set_priority(a.priority);
  if (!a.not_before.empty()) *request.mutable_not_before_time() = queue_instant_from(a.not_before);
  if (a.after != 0) request.set_after_entry_id(a.after);
  request.set_condition(a.when);
  request.set_set_aside_on_failure(a.on_failure == "set-aside");
  if (!a.repeat_every.empty()) *request.mutable_repeat_duration() = queue_span_from(a.repeat_every);
  for (const auto& then : a.then) request.add_follow_ups(then);
  request.set_request_id(a.request_id);
  const auto connection = session.connect();
  take_trajectory(connection, a, request);
  return show_entry(session, connection.ask(&QueueStub::AddQueueEntry, request, 30).entry());
}

ExitCode list_queue(const Session& session, bool over) {
  auto response = session.connect().ask(&QueueStub::ListQueue, v1::ListQueueRequest{});
  if (!session.console.json) {
    print_queue(session.console, response, over);
    return ExitCode::done;
  }
  v1::ListQueueResponse shown;
  if (response.has_hold()) *shown.mutable_hold() = response.hold();
  for (const auto& entry : response.entries())
    if (is_over(entry.state()) == over) *shown.add_entries() = entry;
  session.console.print_json(json_from(shown));
  return ExitCode::done;
}

ExitCode show_one(const Session& session, std::int64_t id) {
  v1::GetQueueEntryRequest request;
  request.set_entry_id(id);
  const auto response = session.connect().ask(&QueueStub::GetQueueEntry, request);
  if (!session.console.json) return show_entry(session, response.entry());
  session.console.print_json(json_from(response));
  return ExitCode::done;
}

ExitCode report_entry(const Session& session, const QueueArguments& a) {
  v1::GetQueueEntryRequest request;
  request.set_entry_id(a.id);
  const auto entry = session.connect().ask(&QueueStub::GetQueueEntry, request).entry();
  if (!entry.has_run_id())
    throw Failure{ExitCode::bad_input, "failed_precondition", "NO_RUN",
                  "queue entry " + std::to_string(a.id) +
                      " has no run yet: its report can be made once it has begun"};
  return save_report(session, entry.run_id(), a.id,
                     a.file.empty() ? "queue-" + std::to_string(a.id) + "-run-" +
                                          std::to_string(entry.run_id()) + ".html"
                                    : a.file);
}

ExitCode edit_entry(const Session& session, const QueueArguments& a) {
  v1::ChangeQueueEntryRequest request;
  request.set_entry_id(a.id);
  if (!a.name.empty()) request.set_name(a.name);
  if (a.has_priority->count() > 0) request.set_priority(a.priority);
  if (!a.not_before.empty())
    *request.mutable_not_before_time() =
        a.not_before == "none" ? google::protobuf::Timestamp{} : queue_instant_from(a.not_before);
  if (a.has_after->count() > 0) request.set_after_entry_id(a.after);
  if (a.has_when->count() > 0) request.set_condition(a.when);
  if (!a.on_failure.empty()) request.set_set_aside_on_failure(a.on_failure == "set-aside");
  if (!a.repeat_every.empty()) *request.mutable_repeat_duration() = queue_span_from(a.repeat_every);
  for (auto& item : metadata_from(a.meta)) *request.add_set_metadata() = std::move(item);
  for (const auto& key : a.remove_meta) request.add_remove_metadata(key);
  return show_entry(session, session.connect().ask(&QueueStub::ChangeQueueEntry, request).entry());
}

ExitCode move_entry(const Session& session, const QueueArguments& a) {
  if ((a.before != 0) + a.front + a.back != 1)
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  "queue move needs one of --before ENTRY, --front and --back"};
  v1::MoveQueueEntryRequest request;
  request.set_entry_id(a.id);
  if (!a.back) request.set_before_entry_id(a.before);
  return show_entry(session, session.connect().ask(&QueueStub::MoveQueueEntry, request).entry());
}

ExitCode remove_entry(const Session& session, const QueueArguments& a) {
  v1::RemoveQueueEntryRequest request;
  request.set_entry_id(a.id);
  request.set_reason(a.reason);
  return show_entry(session, session.connect().ask(&QueueStub::RemoveQueueEntry, request).entry());
}

ExitCode hold_queue(const Session& session, const QueueArguments& a) {
  v1::HoldQueueRequest request;
  request.set_reason(a.reason);
  const auto hold = session.connect().ask(&QueueStub::HoldQueue, request).hold();
  if (session.console.json)
    session.console.print_json(json_from(hold));
  else
    session.console.out << "the queue is " << hold.why()
                        << "; a run under way continues, no entry starts\n";
  return ExitCode::done;
}

ExitCode release_queue(const Session& session) {
  const auto connection = session.connect();
  connection.ask(&QueueStub::ReleaseQueue, v1::ReleaseQueueRequest{});
  const auto queue = connection.ask(&QueueStub::ListQueue, v1::ListQueueRequest{});
  if (session.console.json)
    session.console.print_json(json_from(queue));
  else
    print_queue(session.console, queue, false);
  return ExitCode::done;
}

// Terms of an entry, for add and edit.
void add_terms(CLI::App& command, QueueArguments& a, bool edits) {
  command.add_option("--name", a.name, edits ? "another name" : "of the run; else the file's");
  a.has_priority = command.add_option("--priority", a.priority, "higher first, -1000 to 1000")
                       ->check(number_between(-1000, 1000));
  command.add_option("--not-before", a.not_before,
                     edits ? "UTC, or none" : "UTC: 2026-11-22T23:00:00Z");
  a.has_after = command
                    .add_option("--after", a.after,
                                edits ? "only when this entry was accepted; 0: none"
                                      : "only when this entry was accepted")
                    ->check(number_from_zero());
  a.has_when = command.add_option("--when", a.when,
                                  edits ? "condition to start, '' for none"
                                        : "condition to start: 't12 < 20.5 degC for 30 min'");
  command
      .add_option("--on-failure", a.on_failure,
                  "hold: back in front, the queue is held; set-aside: the next one starts")
      ->check(CLI::IsMember({"hold", "set-aside"}));
  command.add_option("--repeat-every", a.repeat_every,
                     edits ? "from start to start: 12h; 0: once" : "from start to start: 12h");
  command.add_option("--meta", a.meta, "key=value of the run that it becomes; may be repeated");
}

}  // namespace

void add_queue_commands(CLI::App& app, Session& session) {
  CLI::App& queue =
      *app.add_subcommand("queue", "Campaigns that wait for their turn")->require_subcommand(1);
  const auto id = [](CLI::App& command, const std::shared_ptr<QueueArguments>& a) {
    command.add_option("ENTRY", a->id, "number of the entry")->required()->check(positive_number());
  };
  auto added = std::make_shared<QueueArguments>();
  CLI::App& add = add_command(queue, session, "add", "Adds a campaign at the end of its priority",
                              [&session, added] { return add_entry(session, *added); });
  add.add_option("PLAN", added->file, "trajectory CSV, - for standard input");
  add.add_option("--trajectory", added->trajectory, "a kept trajectory instead of a file")
      ->check(positive_number());
  add_terms(add, *added, false);
  add.add_option("--setup", added->setup,
                 "[[setup]] of the cell file: only its instruments are read and required");
  auto* compensate = add.add_flag("--compensate", added->compensate,
                                  "an x_mm trajectory: move to the serving model's targets");
  add.add_option("--model", added->model, "compensate with this model instead")
      ->needs(compensate)
      ->check(positive_number());
  add.add_option(
      "--then", added->then,
      "what follows: 'fit:q ~ x', diagnose, 'diagnose:q ~ x', report, notify; may be repeated");
  add.add_option("--request-id", added->request_id, "the same id again answers with the first one");
  add_command(queue, session, "list", "What runs and what waits, with the reasons",
              [&session] { return list_queue(session, false); });
  add_command(queue, session, "history", "Entries that are over, newest first",
              [&session] { return list_queue(session, true); });
  auto a = std::make_shared<QueueArguments>();
  id(add_command(queue, session, "show", "One entry",
                 [&session, a] { return show_one(session, a->id); }),
     a);
  CLI::App& report = add_command(queue, session, "report",
                                 "The story of an entry's run, and of those it came after, as one "
                                 "HTML page made now",
                                 [&session, a] { return report_entry(session, *a); });
  id(report, a);
  report.add_option("-o,--output", a->file, "the page to write; else queue-ENTRY-run-N.html");
  auto edited = std::make_shared<QueueArguments>();
  CLI::App& edit = add_command(queue, session, "edit", "Changes an entry that waits",
                               [&session, edited] { return edit_entry(session, *edited); });
  id(edit, edited);
  add_terms(edit, *edited, true);
  edit.add_option("--remove-meta", edited->remove_meta, "a key to take away; may be repeated");
  CLI::App& move =
      add_command(queue, session, "move", "Puts an entry elsewhere, or one that was set aside back",
                  [&session, a] { return move_entry(session, *a); });
  id(move, a);
  move.add_option("--before", a->before, "this entry, whose priority it takes")
      ->check(positive_number());
  move.add_flag("--front", a->front, "before all that wait");
  move.add_flag("--back", a->back, "after all that wait");
  CLI::App& remove = add_command(queue, session, "remove", "Takes an entry out that has not begun",
                                 [&session, a] { return remove_entry(session, *a); });
  id(remove, a);
  remove.add_option("--reason", a->reason, "for the record");
  CLI::App& hold = add_command(queue, session, "hold", "No entry starts; a run under way continues",
                               [&session, a] { return hold_queue(session, *a); });
  hold.add_option("--reason", a->reason, "for the record");
  add_command(queue, session, "release", "Entries may start: the robot may move",
              [&session] { return release_queue(session); });
}

}  // namespace driftwise::cli
