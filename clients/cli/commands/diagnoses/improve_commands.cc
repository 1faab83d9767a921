#include "clients/cli/commands/diagnoses/improve_commands.h"

#include <memory>

#include "clients/cli/core/held_lease.h"
#include "clients/cli/core/job_bar.h"
#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "clients/cli/core/trajectory_check.h"
#include "clients/cli/core/validators.h"
#include "driftwise/v1/diagnosis_service.grpc.pb.h"

namespace driftwise::cli {
namespace {

using ImproveStub = v1::DiagnosisService::Stub;

struct ImproveArguments {
  std::string file, formula, lease_token, request_id;
  std::int32_t max_turns = 5;
  double budget_s = 0;
  bool promote = false;
  std::string setup, robot;
  std::int64_t id = 0;
};

std::string state_text_of(v1::Improvement::State state) {
  switch (state) {
    case v1::Improvement::STATE_RUNNING:
      return "running";
    case v1::Improvement::STATE_DONE:
      return "done";
    case v1::Improvement::STATE_CANCELLED:
      return "cancelled";
    case v1::Improvement::STATE_FAILED:
      return "failed";
    default:
      return "unknown";
  }
}

void print_improvement(const Console& console, const v1::Improvement& improvement) {
  const Paint paint = console.paint_out();
  console.out << paint.bold("improvement " + std::to_string(improvement.id()) + ": " +
                            state_text_of(improvement.state()));
  if (!improvement.reason().empty()) console.out << ": " << improvement.reason();
  console.out << "\nfrom " << improvement.formula() << ", measuring "
              << improvement.trajectory_name() << "\n\n";
  Table table({{"turn", Align::right},
               {"runs"},
               {"model", Align::right},
               {"output"},
               {"A90 held out", Align::right},
               {"promised", Align::right},
               {"fresh: before", Align::right},
               {"after", Align::right},
               {"mean", Align::right}});
  for (const auto& turn : improvement.turns()) {
    std::string runs;
    for (const auto run : turn.run_ids()) runs += (runs.empty() ? "" : ", ") + std::to_string(run);
    const std::string model = turn.has_model_id() ? std::to_string(turn.model_id()) : "";
    if (turn.gains().empty())
      table.add({std::to_string(turn.number()), runs, model, "-", "-", "-", "-", "-", "-"});
    for (const auto& gain : turn.gains())
      table.add({std::to_string(turn.number()), runs, model,
                 gain.output() + " (" + gain.unit() + ")", fixed(gain.before().a90(), 1),
                 gain.has_predicted() ? fixed(gain.predicted().a90(), 1) : "-",
                 gain.has_measured_before() ? fixed(gain.measured_before().a90(), 1) : "-",
                 gain.has_measured() ? fixed(gain.measured().a90(), 1) : "-",
                 gain.has_measured() ? signed_fixed(gain.measured().mean(), 1) : "-"});
  }
  if (!table.empty()) table.print(console.out, paint);
  for (const auto& turn : improvement.turns())
    console.out << "\nturn " << turn.number() << ": " << turn.what() << '\n';
}

ExitCode show_improvement(const Session& session, const v1::Improvement& improvement) {
  if (session.console.json)
    session.console.print_json(json_from(improvement));
  else
    print_improvement(session.console, improvement);
  switch (improvement.state()) {
    case v1::Improvement::STATE_CANCELLED:
    case v1::Improvement::STATE_FAILED:
      return ExitCode::refused;
    default:
      return ExitCode::done;
  }
}

v1::Improvement get_improvement(const Connection& connection, std::int64_t id) {
  v1::GetImprovementRequest request;
  request.set_improvement_id(id);
  return connection.ask(&ImproveStub::GetImprovement, request).improvement();
}

// Interrupted it is cancelled; an end of the watching alone leaves it, and the lease, as they are.
void follow_improvement(const Session& session, const Connection& connection, std::int64_t id,
                        HeldLease& lease) {
  v1::WatchImprovementRequest request;
  request.set_improvement_id(id);
  JobBar bar(session.console);
  try {
    connection.follow(&ImproveStub::WatchImprovement, request,
                      [&](const v1::WatchImprovementResponse& response) {
                        const auto& progress = response.progress();
                        bar.show("turn " + std::to_string(progress.turn()), -1, progress.step());
                        return true;
                      });
  } catch (Failure& failure) {
    if (failure.exit != ExitCode::interrupted) {
      lease.leave();
      const std::string number = std::to_string(id);
      if (failure.reason == "TIMEOUT")
        failure.message = "time is up: improvement " + number +
                          " goes on; look at it with `driftwise improve show " + number +
                          "`, end it with `driftwise improve cancel " + number + "`";
      throw;
    }
    v1::CancelImprovementRequest cancel;
    cancel.set_improvement_id(id);
    const auto ended =
        connection.uninterrupted().ask(&ImproveStub::CancelImprovement, cancel).improvement();
    failure.message = "interrupted: improvement " + std::to_string(id) +
                      (ended.state() == v1::Improvement::STATE_FAILED ? " " : " is ") +
                      state_text_of(ended.state()) + ": " + ended.reason() + "; its runs stay";
    throw;
  }
}

ExitCode improve(const Session& session, const ImproveArguments& a) {
  const auto connection = session.connect();
  v1::CreateImprovementRequest request;
  request.set_trajectory_name(base_name(a.file));
  request.set_trajectory_text(read_input_file(a.file));
  request.set_formula(a.formula);
  request.set_max_turns(a.max_turns);
  request.set_budget_s(a.budget_s);
  request.set_promote(a.promote);
  request.set_setup(a.setup);
  request.set_robot(a.robot);
  request.set_request_id(a.request_id);
  check_trajectory(connection, request.trajectory_text(), a.file);
  HeldLease lease(connection, a.lease_token);
  request.set_lease_token(lease.token());
  const auto begun = connection.ask(&ImproveStub::CreateImprovement, request, 30).improvement();
  follow_improvement(session, connection, begun.id(), lease);
  return show_improvement(session, get_improvement(connection, begun.id()));
}

ExitCode list_improvements(const Session& session) {
  const auto response =
      session.connect().ask(&ImproveStub::ListImprovements, v1::ListImprovementsRequest{});
  if (session.console.json) {
    session.console.print_json(json_from(response));
    return ExitCode::done;
  }
  Table table({{"improvement", Align::right},
               {"began (UTC)"},
               {"by"},
               {"plan"},
               {"turns", Align::right},
               {"state"},
               {"why it ended"}});
  for (const auto& one : response.improvements())
    table.add({std::to_string(one.id()), clock_text(one.create_time()), one.created_by(),
               one.trajectory_name(), std::to_string(one.turns_size()), state_text_of(one.state()),
               one.reason()});
  if (table.empty())
    session.console.out << "no improvement was begun yet\n";
  else
    table.print(session.console.out, session.console.paint_out());
  return ExitCode::done;
}

ExitCode cancel_improvement(const Session& session, std::int64_t id) {
  v1::CancelImprovementRequest request;
  request.set_improvement_id(id);
  const auto cancelled =
      session.connect().ask(&ImproveStub::CancelImprovement, request).improvement();
  if (session.console.json)
    session.console.print_json(json_from(cancelled));
  else
    print_improvement(session.console, cancelled);
  return ExitCode::done;
}

}  // namespace

void add_improve_commands(CLI::App& app, Session& session) {
  auto a = std::make_shared<ImproveArguments>();
  CLI::App& command = *app.add_subcommand(
      "improve", "Measures, diagnoses, extends and measures again, until nothing is left");
  command.require_subcommand(0, 1);
  command.callback([&session, &command, a] {
    if (command.get_subcommands().empty())
      session.action = [&session, a] {
        if (a->file.empty())
          throw Failure{ExitCode::usage, "usage", "USAGE",
                        "improve needs the trajectory to measure: driftwise improve PLAN.csv"};
        return improve(session, *a);
      };
  });
  command.add_option("PLAN", a->file, "trajectory CSV: the measurement of every turn");
  command.add_option("--model", a->formula,
                     "formula of the first model; else that of the model that serves");
  command.add_option("--max-turns", a->max_turns, "at most so many")
      ->check(number_between(1, 50))
      ->capture_default_str();
  command.add_option("--budget", a->budget_s, "seconds of cell time; else no limit")
      ->check(positive_number());
  command.add_option("--setup", a->setup,
                     "[[setup]] of the cell file that measures; else every instrument");
  command.add_option("--robot", a->robot,
                     "of a cell with several: ma; else the one that the formula's outputs name");
  command.add_flag("--promote", a->promote,
                   "a model whose gain the fresh points have shown serves; else it is proposed");
  command.add_option("--lease-token", a->lease_token,
                     "of a lease taken with `driftwise lease take`");
  command.add_option("--request-id", a->request_id, "the same id again answers with the first one");
  const auto id = [a](CLI::App& one) {
    one.add_option("IMPROVEMENT", a->id, "number of the improvement")
        ->required()
        ->check(positive_number());
  };
  add_command(command, session, "list", "Improvements, newest first",
              [&session] { return list_improvements(session); });
  id(add_command(command, session, "show", "One improvement, turn by turn", [&session, a] {
    return show_improvement(session, get_improvement(session.connect(), a->id));
  }));
  id(add_command(command, session, "cancel", "Ends one that is under way; its runs stay",
                 [&session, a] { return cancel_improvement(session, a->id); }));
}

}  // namespace driftwise::cli
