#include "clients/cli/commands/runs/run_commands.h"

#include <chrono>
#include <memory>
#include <thread>

#include "clients/cli/commands/data/remark_commands.h"
#include "clients/cli/commands/look_back/look_back_commands.h"
#include "clients/cli/commands/runs/run_start.h"
#include "clients/cli/commands/runs/run_tables.h"
#include "clients/cli/commands/runs/run_watch.h"
#include "clients/cli/commands/runs/verify_command.h"
#include "clients/cli/core/hold_question.h"
#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/validators.h"
#include "clients/cli/pages/metadata_text.h"
#include "clients/cli/pages/run_text.h"
#include "driftwise/v1/cell_service.grpc.pb.h"
#include "driftwise/v1/run_service.grpc.pb.h"

namespace driftwise::cli {
namespace {

using RunStub = v1::RunService::Stub;

struct RunArguments {
  std::int64_t id = 0;
  std::int32_t limit = 20;
  std::string reason;
  double force_n = 0;
  HoldOptions hold;
  std::vector<std::string> meta, tags, removed;
};

ExitCode show_changed(const Session& session, const v1::Run& run) {
  if (session.console.json)
    session.console.print_json(json_from(run));
  else
    print_run(session.console, run);
  return ExitCode::done;
}

ExitCode list_runs(const Session& session, const RunArguments& a) {
  v1::ListRunsRequest request;
  request.set_limit(a.limit);
  for (auto& item : metadata_from(a.meta)) *request.add_metadata() = std::move(item);
  const auto response = session.connect().ask(&RunStub::ListRuns, request);
  if (session.console.json)
    session.console.print_json(json_from(response));
  else
    print_runs(session.console, {response.runs().begin(), response.runs().end()}, a.meta);
  return ExitCode::done;
}

ExitCode tag_run(const Session& session, const RunArguments& a) {
  if (a.tags.empty() && a.removed.empty())
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  "run tag needs what to set or remove: driftwise run tag 3 sample=A12"};
  v1::TagRunRequest request;
  request.set_run_id(a.id);
  for (auto& item : metadata_from(a.tags)) *request.add_set() = std::move(item);
  for (const auto& key : a.removed) {
    if (key.find('=') != std::string::npos)
      throw Failure{ExitCode::usage, "usage", "USAGE",
                    "--remove: found '" + key + "', expected a key alone, without a value"};
    request.add_remove(key);
  }
  return show_changed(session, session.connect().ask(&RunStub::TagRun, request).run());
}

ExitCode show_run(const Session& session, std::int64_t id) {
  v1::GetRunRequest request;
  request.set_run_id(id);
  const auto connection = session.connect();
  const auto response = connection.ask(&RunStub::GetRun, request);
  const auto notes = notes_of_run(connection, id);
  const auto closures = closures_of_run(connection, id);
  if (session.console.json) {
    auto json = json_from(response);
    json.update(json_from(notes));
    json.update(json_from(closures));
    session.console.print_json(json);
    return ExitCode::done;
  }
  print_run(session.console, response.run());
  if (!is_over(response.run().state())) {
    const auto status = connection.ask(&v1::CellService::Stub::GetStatus, v1::GetStatusRequest{});
    if (status.run().run().id() == id) print_ahead(session.console, status.run());
  }
  print_closure_summary(session.console, closures);
  print_notes(session.console, notes);
  return ExitCode::done;
}

ExitCode watch(const Session& session, std::optional<std::int64_t> id) {
  const auto connection = session.connect();
  const auto run = watch_until_over(session, connection, id);
  if (!session.console.json) print_run(session.console, run);
  return exit_code_of(run.state());
}

// The axes are stopped first, so that the answer still shows the run as it was: what is printed is
// what became of it, where that comes soon.
ExitCode abort_run(const Session& session, std::int64_t id, const std::string& reason) {
  constexpr std::chrono::milliseconds kPatience{5000}, kBetween{50};
  v1::AbortRunRequest request;
  request.set_run_id(id);
  request.set_reason(reason);
  const auto halting = session.connect_for_halting("ABORTED");
  auto run = halting.ask(&RunStub::AbortRun, request).run();
  const auto connection = halting.for_halting(nullptr);
  const auto until = std::chrono::steady_clock::now() + kPatience;
  v1::GetRunRequest look;
  look.set_run_id(id);
  while (!is_over(run.state()) && std::chrono::steady_clock::now() < until &&
         !connection.interrupted()) {
    std::this_thread::sleep_for(kBetween);
    run = connection.ask(&RunStub::GetRun, look).run();
  }
  const ExitCode exit = show_changed(session, run);
  if (!is_over(run.state()) && !session.console.json)
    session.console.err << "it ends as soon as the axes stand: follow it with `driftwise run watch "
                        << id << "`\n";
  return exit;
}

ExitCode confirm_force(const Session& session, std::int64_t id, double force_n) {
  v1::ConfirmForceRequest request;
  request.set_run_id(id);
  request.set_force_n(force_n);
  return show_changed(session, session.connect().ask(&RunStub::ConfirmForce, request).run());
}

// The engine looks at what is wanted of it between two steps, so the answer may still show the
// state before: then `what_follows` says what will happen.
template <class Request, class Method>
ExitCode change(const Session& session, Method method, std::int64_t id, v1::Run::State wanted,
                const std::string& what_follows) {
  Request request;
  request.set_run_id(id);
  const auto run = session.connect_for_halting("PAUSED").ask(method, request).run();
  const ExitCode exit = show_changed(session, run);
  if (run.state() != wanted && !session.console.json)
    session.console.err << what_follows << ": follow it with `driftwise run watch " << id << "`\n";
  return exit;
}

ExitCode resume_run(const Session& session, std::int64_t id, const HoldOptions& options) {
  const auto connection = session.connect();
  v1::GetRunRequest asked;
  asked.set_run_id(id);
  const auto before = connection.ask(&RunStub::GetRun, asked).run();
  const auto now =
      connection.ask(&v1::CellService::Stub::GetStatus, v1::GetStatusRequest{}).cell_time();
  v1::ResumeRunRequest request;
  request.set_run_id(id);
  *request.mutable_answer() =
      answer_about(session.console, before, now, options, "Resume run " + std::to_string(id));
  const auto run = connection.ask(&RunStub::ResumeRun, request).run();
  const ExitCode exit = show_changed(session, run);
  if (run.state() != v1::Run::STATE_RUNNING && !session.console.json)
    session.console.err << "it goes on as soon as the devices were looked at: follow it with "
                           "`driftwise run watch "
                        << id << "`\n";
  return exit;
}

}  // namespace

void add_run_commands(CLI::App& app, Session& session) {
  CLI::App& run = *app.add_subcommand("run", "Measuring campaigns")->require_subcommand(1);
  auto a = std::make_shared<RunArguments>();
  const auto id = [a](CLI::App& command) {
    command.add_option("RUN", a->id, "number of the run")->required();
  };

  add_run_start(run, session);
  CLI::App& list = add_command(run, session, "list", "Runs, newest first",
                               [&session, a] { return list_runs(session, *a); });
  list.add_option("--limit", a->limit, "how many")
      ->check(number_between(1, 1000))
      ->capture_default_str();
  list.add_option("--meta", a->meta, "only runs with this key=value; may be repeated")
      ->allow_extra_args(false);
  CLI::App& tagged = add_command(run, session, "tag", "Sets and removes metadata of a run",
                                 [&session, a] { return tag_run(session, *a); });
  id(tagged);
  tagged.add_option("KEY=VALUE", a->tags, "sample=A12 tool=probe");
  tagged.add_option("--remove", a->removed, "a key to take away; may be repeated")
      ->allow_extra_args(false);
  id(add_command(run, session, "show", "One run",
                 [&session, a] { return show_run(session, a->id); }));
  CLI::App& watched = add_command(run, session, "watch", "Follows a run to its end", [&session, a] {
    return watch(session, a->id != 0 ? std::optional(a->id) : std::nullopt);
  });
  watched.add_option("RUN", a->id, "number of the run; without it the one under way");
  id(add_command(run, session, "pause", "Pauses after the point under way", [&session, a] {
    return change<v1::PauseRunRequest>(session, &RunStub::PauseRun, a->id, v1::Run::STATE_PAUSED,
                                       "it pauses after the point under way");
  }));
  CLI::App& resumed =
      add_command(run, session, "resume", "Goes on with a paused run; asks who paused it",
                  [&session, a] { return resume_run(session, a->id, a->hold); });
  id(resumed);
  add_hold_options(resumed, a->hold);
  CLI::App& ended =
      add_command(run, session, "abort", "Ends a run at once; what was accepted stays",
                  [&session, a] { return abort_run(session, a->id, a->reason); });
  id(ended);
  ended.add_option("--reason", a->reason, "for the record");
  CLI::App& confirmed =
      add_command(run, session, "confirm", "Says that the force a run waits for acts now",
                  [&session, a] { return confirm_force(session, a->id, a->force_n); });
  id(confirmed);
  confirmed.add_option("--force", a->force_n, "what hangs there, N")
      ->required()
      ->check(finite_number());
  add_verify_command(run, session);
  add_compare_command(run, session);
  id(add_command(run, session, "points", "Accepted points",
                 [&session, a] { return show_points(session, a->id); }));
  id(add_command(run, session, "attempts", "Every attempt, with its verdict",
                 [&session, a] { return show_attempts(session, a->id); }));
  id(add_command(run, session, "datums", "Its zeroings, with the conditions at each",
                 [&session, a] { return show_datums(session, a->id); }));
}

}  // namespace driftwise::cli
