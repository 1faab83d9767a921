#include "clients/cli/commands/plans/plan_commands.h"

#include <memory>

#include "clients/cli/core/assignment.h"
#include "clients/cli/core/confirm.h"
#include "clients/cli/core/connection.h"
#include "clients/cli/core/input_text.h"
#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "clients/cli/core/validators.h"
#include "driftwise/v1/plan_service.grpc.pb.h"

namespace driftwise::cli {
namespace {

using PlanStub = v1::PlanService::Stub;

struct ServingPlanArguments {
  std::string file, note, request_id, what;
  std::int64_t id = 0;
  std::vector<std::string> pose;
  bool yes = false, dry_run = false;
};

std::string models_text(const v1::Plan& plan) {
  std::string models;
  for (const auto model : plan.model_ids())
    models += (models.empty() ? "" : ", ") + std::to_string(model);
  return models;
}

void print_plan_line(const Console& console, const v1::Plan& plan) {
  console.out << "plan " << plan.id() << " '" << plan.name() << "', version " << plan.version()
              << ", models " << models_text(plan) << (plan.serves() ? ", serves" : "") << '\n';
}

ExitCode add_plan(const Session& session, const ServingPlanArguments& a) {
  v1::AddPlanRequest request;
  request.set_text(read_input_file(a.file));
  request.set_note(a.note);
  request.set_request_id(a.request_id);
  const auto plan = session.connect().ask(&PlanStub::AddPlan, request).plan();
  if (session.console.json)
    session.console.print_json(json_from(plan));
  else
    print_plan_line(session.console, plan);
  return ExitCode::done;
}

ExitCode list_plans(const Session& session) {
  const auto response = session.connect().ask(&PlanStub::ListPlans, v1::ListPlansRequest{});
  if (session.console.json) {
    session.console.print_json(json_from(response));
    return ExitCode::done;
  }
  Table table({{"plan", Align::right},
               {"name"},
               {"version", Align::right},
               {"models"},
               {"added (UTC)"},
               {"by"},
               {"serves"}});
  for (const auto& plan : response.plans())
    table.add({std::to_string(plan.id()), plan.name(), std::to_string(plan.version()),
               models_text(plan), clock_text(plan.create_time()), plan.created_by(),
               plan.serves() ? "yes" : ""});
  table.print(session.console.out, session.console.paint_out());
  if (!response.trouble().empty())
    session.console.out << session.console.paint_out().warn("! ") << response.trouble() << '\n';
  return ExitCode::done;
}

ExitCode show_plan(const Session& session, std::int64_t id) {
  v1::GetPlanRequest request;
  request.set_plan_id(id);
  const auto response = session.connect().ask(&PlanStub::GetPlan, request);
  if (session.console.json) {
    session.console.print_json(json_from(response));
    return ExitCode::done;
  }
  auto& out = session.console.out;
  print_plan_line(session.console, response.plan());
  out << "added " << clock_text(response.plan().create_time()) << " UTC by "
      << response.plan().created_by() << ", SHA-256 " << response.plan().hash() << '\n';
  if (!response.plan().note().empty()) out << response.plan().note() << '\n';
  out << '\n';
  for (int i = 0; i < response.steps_size(); ++i) out << i + 1 << ". " << response.steps(i) << '\n';
  out << '\n' << response.text();
  if (!response.text().empty() && response.text().back() != '\n') out << '\n';
  return ExitCode::done;
}

bool plan_refuses(const v1::CheckPlanResponse& check) {
  for (const auto& finding : check.findings())
    if (finding.refuses()) return true;
  return false;
}

void print_plan_check(const Console& console, const v1::CheckPlanResponse& check) {
  const Paint paint = console.paint_out();
  for (const auto& band : check.bands()) {
    console.out << "blend" << (band.robot().empty() ? "" : " of robot " + band.robot())
                << ": models differ by " << significant(band.largest_difference_nm(), 4)
                << " nm of " << band.largest_channel();
    if (band.difference_arcsec() > 0)
      console.out << " (" << significant(band.difference_arcsec(), 4) << " arcsec)";
    console.out << "; rates deviate by " << fixed(band.rate_share(), 3)
                << " of the fine model's largest (below 0.5)";
    if (band.determinant_share() != 0)
      console.out << ", determinant at least " << fixed(band.determinant_share(), 3)
                  << " of its size (above 0.5)";
    console.out << '\n';
  }
  for (const auto& finding : check.findings())
    console.out << (finding.refuses() ? paint.bad("refused ") + finding.reason() + ": "
                                      : paint.warn("question ") + finding.reason() + ": ")
                << finding.message() << '\n';
  if (!plan_refuses(check)) console.out << "the plan can be promoted\n";
}

// A number is a stored plan, anything else a file.
v1::CheckPlanRequest check_request(const std::string& what) {
  v1::CheckPlanRequest request;
  const auto id = number_from(what);
  if (id && *id >= 1 && *id < 1e15 && *id == static_cast<double>(static_cast<std::int64_t>(*id)))
    request.set_plan_id(static_cast<std::int64_t>(*id));
  else
    request.set_text(read_input_file(what));
  return request;
}

ExitCode check_one(const Session& session, const std::string& what) {
  const auto response = session.connect().ask(&PlanStub::CheckPlan, check_request(what), 60);
  if (session.console.json)
    session.console.print_json(json_from(response));
  else
    print_plan_check(session.console, response);
  return plan_refuses(response) ? ExitCode::negative : ExitCode::done;
}

ExitCode promote_plan(const Session& session, const ServingPlanArguments& a) {
  const auto connection = session.connect();
  v1::GetPlanRequest looked_at;
  looked_at.set_plan_id(a.id);
  const auto present = connection.ask(&PlanStub::GetPlan, looked_at).plan();
  if (present.serves()) {
    if (session.console.json)
      session.console.print_json(json_from(present));
    else
      session.console.out << "plan " << a.id << " serves already: nothing was changed\n";
    return ExitCode::done;
  }
  // Looked at before the questions: another one that begins to serve meanwhile stays.
  const auto list = connection.ask(&PlanStub::ListPlans, v1::ListPlansRequest{});
  std::int64_t serving = 0;
  for (const auto& one : list.plans())
    if (one.serves()) serving = one.id();
  v1::CheckPlanRequest asked;
  asked.set_plan_id(a.id);
  const auto check = connection.ask(&PlanStub::CheckPlan, asked, 60);
  if (a.dry_run) {
    if (session.console.json)
      session.console.print_json({{"dry_run", true}, {"check", json_from(check)}});
    else
      print_plan_check(session.console, check);
    return plan_refuses(check) ? ExitCode::negative : ExitCode::done;
  }
  std::vector<std::string> facts;
  for (const auto& finding : check.findings())
    if (!finding.refuses()) facts.push_back(finding.message());
  if (!facts.empty() && !plan_refuses(check))
    confirm(session.console, a.yes,
            "plan " + std::to_string(a.id) + " would serve every controller, although:", facts,
            "Promote it");
  v1::PromotePlanRequest request;
  request.set_plan_id(a.id);
  request.set_confirmed(!facts.empty());
  request.set_serving_plan_id(serving);
  const auto plan = connection.ask(&PlanStub::PromotePlan, request, 60).plan();
  if (session.console.json)
    session.console.print_json(json_from(plan));
  else
    print_plan_line(session.console, plan);
  return ExitCode::done;
}

// The history is that of all plans, whichever is asked for.
ServedIds served_plans(const Connection& connection) {
  ServedIds served;
  const auto list = connection.ask(&PlanStub::ListPlans, v1::ListPlansRequest{});
  if (list.plans().empty()) return served;
  v1::GetPlanRequest any;
  any.set_plan_id(list.plans(0).id());
  const auto page = connection.ask(&PlanStub::GetPlan, any);
  for (const auto& one : page.promotions()) {
    if (one.rollback())
      served.rolled_back(one.has_plan_id() ? std::optional(one.plan_id()) : std::nullopt);
    else if (one.has_plan_id())
      served.promoted(one.plan_id());
  }
  return served;
}

// Consequences of putting it back.
std::vector<std::string> facts_of_plan(const Connection& connection, std::int64_t id) {
  v1::GetPlanRequest asked;
  asked.set_plan_id(id);
  const auto plan = connection.ask(&PlanStub::GetPlan, asked).plan();
  std::vector<std::string> facts = {"plan " + std::to_string(id) + " '" + plan.name() +
                                    "' serves again: models " + models_text(plan)};
  v1::CheckPlanRequest of_it;
  of_it.set_plan_id(id);
  const auto check = connection.ask(&PlanStub::CheckPlan, of_it, 60);
  for (const auto& finding : check.findings()) facts.push_back("although " + finding.message());
  return facts;
}

ExitCode roll_back_plan(const Session& session, bool yes) {
  const auto connection = session.connect();
  const auto serving =
      confirm_rollback(session.console, yes, served_plans(connection),
                       {"plan", "every joint target is refused (NO_PLAN)",
                        [&](std::int64_t id) { return facts_of_plan(connection, id); }});
  v1::RollBackPlanRequest request;
  if (serving) request.set_serving_plan_id(*serving);
  const auto response = connection.ask(&PlanStub::RollBackPlan, request, 60);
  if (session.console.json)
    session.console.print_json(
        {{"plan", response.has_plan() ? json_from(response.plan()) : nullptr}});
  else if (response.has_plan())
    print_plan_line(session.console, response.plan());
  else
    session.console.out << "no plan serves now\n";
  return ExitCode::done;
}

std::string answered_text(const v1::RobotAnswer& robot) {
  const std::string fine = "model " + std::to_string(robot.model_id());
  const std::string coarse = "model " + std::to_string(robot.coarse_model_id());
  switch (robot.by()) {
    case v1::RobotAnswer::BY_FINE:
      return fine + " (fine)";
    case v1::RobotAnswer::BY_COARSE:
      return coarse + " (coarse)";
    case v1::RobotAnswer::BY_BLEND:
      return fixed(robot.fine_weight(), 3) + " of " + fine + " and the rest of " + coarse +
             ", which differ by " + fixed(robot.difference_nm(), 1) + " nm";
    default:
      return fine;
  }
}

void print_joint_target(const Console& console, const v1::JointTarget& target) {
  if (target.terms_size() > 0) {
    Table terms({{"predicted"},
                 {"added to"},
                 {"value", Align::right},
                 {"u", Align::right},
                 {"unit"},
                 {"model", Align::right}});
    for (const auto& term : target.terms())
      terms.add({term.from_channel(),
                 term.to_channel().empty() ? "- (not corrected)" : term.to_channel(),
                 signed_fixed(term.value(), term.unit() == "nm" ? 1 : 3),
                 fixed(term.u(), term.unit() == "nm" ? 1 : 3), term.unit(),
                 std::to_string(term.model_id())});
    terms.print(console.out, console.paint_out());
    console.out << '\n';
  }
  Table table({{"coordinate"},
               {"mm", Align::right},
               {"u nm", Align::right},
               {"U90 nm", Align::right},
               {"U (k=2) nm", Align::right}});
  for (const auto& coordinate : target.coordinates()) {
    const std::string symbol = coordinate.channel().substr(0, coordinate.channel().rfind('_'));
    table.add({symbol + (coordinate.has_min_mm() ? " (not reachable)" : ""),
               fixed(coordinate.position_mm(), 7), fixed(coordinate.u_nm(), 1),
               fixed(coordinate.u90_nm(), 1), fixed(coordinate.expanded_nm(), 1)});
  }
  table.print(console.out, console.paint_out());
  for (const auto& robot : target.robots())
    console.out << (robot.robot().empty() ? "the robot" : robot.robot()) << ": "
                << answered_text(robot) << '\n';
  console.out << "plan " << target.plan_id() << ", conditions of "
              << clock_text(target.conditions_time()) << " UTC, valid until "
              << utc_text(target.valid_until_time()).substr(11) << '\n';
  for (const auto& flag : target.flags())
    console.out << console.paint_out().warn("! ") << flag << '\n';
}

ExitCode joint_target(const Session& session, const ServingPlanArguments& a) {
  v1::ComputeJointTargetRequest request;
  *request.mutable_pose() = assignments_from(a.pose);
  request.set_show_unreachable(true);
  const auto target = session.connect().ask(&PlanStub::ComputeJointTarget, request).target();
  if (session.console.json)
    session.console.print_json(json_from(target));
  else
    print_joint_target(session.console, target);
  for (const auto& coordinate : target.coordinates())
    if (coordinate.has_min_mm()) return ExitCode::negative;
  return ExitCode::done;
}

}  // namespace

void add_plan_commands(CLI::App& app, Session& session) {
  CLI::App& plan =
      *app.add_subcommand("plan", "Serving plans: what a target of several robots is made of")
           ->require_subcommand(1);
  auto a = std::make_shared<ServingPlanArguments>();
  const auto id = [a](CLI::App& command) {
    command.add_option("PLAN", a->id, "number of the plan")->required()->check(positive_number());
  };
  CLI::App& add = add_command(plan, session, "add", "Stores a plan; nothing serves by it yet",
                              [&session, a] { return add_plan(session, *a); });
  add.add_option("FILE", a->file, "plan.toml, - for standard input")->required();
  add.add_option("--note", a->note, "for the record");
  add.add_option("--request-id", a->request_id, "the same id again answers with the first one");
  add_command(plan, session, "list", "All plans, and which of them serves",
              [&session] { return list_plans(session); });
  id(add_command(plan, session, "show", "One plan, step by step, and its text",
                 [&session, a] { return show_plan(session, a->id); }));
  CLI::App& check = add_command(plan, session, "check", "What stands against a plan's promotion",
                                [&session, a] { return check_one(session, a->what); });
  check.add_option("WHAT", a->what, "number of a stored plan, or a file")->required();
  CLI::App& promote = add_command(plan, session, "promote", "Joint targets come from this plan",
                                  [&session, a] { return promote_plan(session, *a); });
  id(promote);
  promote.add_flag("--yes", a->yes, "answers the questions of the check");
  promote.add_flag("--dry-run", a->dry_run, "only checks");
  CLI::App& rolled =
      add_command(plan, session, "rollback", "The plan that served before serves again; asks",
                  [&session, a] { return roll_back_plan(session, a->yes); });
  rolled.add_flag("--yes", a->yes, "ask nothing: for scripts");
  CLI::App& target = add_command(plan, session, "target",
                                 "Motor coordinates of all robots for a pose; moves nothing",
                                 [&session, a] { return joint_target(session, *a); });
  target.add_option("POSE", a->pose, "mn.x=1.5 ma.rx=100 ..., mm, arcsec, N")->required();
}

}  // namespace driftwise::cli
