#include "clients/cli/commands/models/model_commands.h"

#include <cmath>
#include <memory>

#include "clients/cli/commands/data/remark_commands.h"
#include "clients/cli/commands/models/check_command.h"
#include "clients/cli/commands/models/kinematic_commands.h"
#include "clients/cli/commands/models/ladder_commands.h"
#include "clients/cli/commands/models/method_commands.h"
#include "clients/cli/commands/models/residuals_command.h"
#include "clients/cli/commands/models/sensors_command.h"
#include "clients/cli/commands/record/record_file.h"
#include "clients/cli/core/confirm.h"
#include "clients/cli/core/input_text.h"
#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "clients/cli/core/validators.h"
#include "clients/cli/pages/accuracy_line.h"
#include "clients/cli/pages/model_page.h"
#include "driftwise/v1/cell_service.grpc.pb.h"
#include "driftwise/v1/model_service.grpc.pb.h"
#include "driftwise/v1/record_service.grpc.pb.h"

namespace driftwise::cli {
namespace {

using ModelStub = v1::ModelService::Stub;

struct ModelArguments {
  std::int64_t id = 0;
  std::vector<std::string> what;   // of compare: numbers of models, or one file; or else ...
  std::vector<std::int64_t> runs;  // ... these, whose methods are compared
  FitOfFile fit;
  MethodsOfFile methods;
  std::string format = "json", file, reason;
  bool dry_run = false, yes = false;
};

ExitCode show(const Session& session, std::int64_t id) {
  v1::GetModelRequest request;
  request.set_model_id(id);
  const auto connection = session.connect();
  const auto shown = connection.ask(&ModelStub::GetModel, request);
  const auto notes = notes_of_model(connection, id);
  if (session.console.json) {
    // The model's own keys first, as ever; the rest of the page beside them.
    auto page = json_from(shown);
    auto model = page["model"];
    page.erase("model");
    model.update(page);
    model.update(json_from(notes));
    const auto head = connection.ask(&v1::RecordService::Stub::GetChainHead, {}).head();
    if (head.entry() > 0) model["record_head"] = head_text(head);
    session.console.print_json(model);
    return ExitCode::done;
  }
  print_model_page(session.console, shown);
  print_notes(session.console, notes);
  return ExitCode::done;
}

ExitCode list(const Session& session) {
  const auto response = session.connect().ask(&ModelStub::ListModels, v1::ListModelsRequest{});
  if (session.console.json)
    session.console.print_json(json_from(response));
  else
    print_models(session.console, {response.models().begin(), response.models().end()});
  return ExitCode::done;
}

ExitCode compare(const Session& session, const ModelArguments& a) {
  if (a.what.empty() == a.runs.empty())
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  std::string("compare what? found ") +
                      (a.what.empty() ? "nothing" : "models or a file, and --run") +
                      "; give numbers of models, or one dataset file, or --run N"};
  if (!a.runs.empty()) return compare_methods_of_runs(session, a.fit, a.methods, a.runs);
  v1::CompareModelsRequest request;
  for (const auto& one : a.what) {
    const auto id = number_from(one);
    if (a.what.size() == 1 && !id)
      return compare_methods(session.console, a.fit, a.methods, InputText(one).text(), one);
    if (!id || *id < 1 || *id != std::floor(*id) || *id > 1e15)
      throw Failure{ExitCode::usage, "usage", "USAGE",
                    "found '" + one + "', expected numbers of models, or one dataset file"};
    request.add_model_ids(static_cast<std::int64_t>(*id));
  }
  if (request.model_ids_size() < 2)
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  "found one model, expected 2 to 16 of them, or one dataset file"};
  const auto response = session.connect().ask(&ModelStub::CompareModels, request);
  if (session.console.json)
    session.console.print_json(json_from(response));
  else
    print_comparison(session.console, response);
  return ExitCode::done;
}

ExitCode serving_now(const Session& session, bool any, const v1::Model& model) {
  if (session.console.json)
    session.console.print_json({{"model", any ? json_from(model) : nullptr}});
  else if (any) {
    session.console.out << "model " << model.id() << " serves now: " << model.formula() << '\n';
    for (const auto& one : model.accuracy())
      session.console.out << "accuracy (A90) " << accuracy_text(one) << '\n';
  } else {
    session.console.out << "no model serves now\n";
  }
  return ExitCode::done;
}

ExitCode promote(const Session& session, const ModelArguments& a) {
  const auto connection = session.connect();
  // Looked at before the questions: another one that begins to serve meanwhile stays.
  const auto status = connection.ask(&v1::CellService::Stub::GetStatus, v1::GetStatusRequest{});
  v1::GetModelRequest asked;
  asked.set_model_id(a.id);
  const auto page = connection.ask(&ModelStub::GetModel, asked);
  if (page.model().serving()) {
    if (session.console.json)
      session.console.print_json({{"serves_already", true}, {"model", json_from(page.model())}});
    else
      session.console.out << "model " << a.id << " serves already: nothing was changed\n";
    return ExitCode::done;
  }
  if (a.dry_run) {
    const auto& model = page.model();
    if (session.console.json)
      session.console.print_json({{"dry_run", true}, {"model", json_from(model)}});
    else {
      session.console.out << "dry run: model " << model.id() << " would serve: " << model.formula()
                          << '\n';
      for (const auto& one : model.accuracy())
        session.console.out << "accuracy (A90) " << accuracy_text(one) << '\n';
    }
    return ExitCode::done;
  }
  std::vector<std::string> facts(page.promotion_questions().begin(),
                                 page.promotion_questions().end());
  if (!page.questions_for_a_reason().empty() && a.reason.empty())
    throw Failure{ExitCode::refused, "failed_precondition", "REASON_REQUIRED",
                  page.questions_for_a_reason(0) +
                      ": say why it serves all the same, for the record: --reason 'TEXT'"};
  if (!facts.empty())
    confirm(session.console, a.yes,
            "model " + std::to_string(a.id) + " would serve every controller, although:", facts,
            "Promote it");
  v1::PromoteModelRequest request;
  request.set_model_id(a.id);
  request.set_confirmed(!facts.empty());
  request.set_reason(a.reason);
  request.set_serving_model_id(status.has_serving_model_id() ? status.serving_model_id() : 0);
  return serving_now(session, true, connection.ask(&ModelStub::PromoteModel, request).model());
}

ServedIds served_models(const v1::ListPromotionsResponse& oldest_first) {
  ServedIds served;
  for (const auto& one : oldest_first.promotions()) {
    if (one.action() == v1::Promotion::ACTION_ROLLBACK)
      served.rolled_back(one.has_model_id() ? std::optional(one.model_id()) : std::nullopt);
    else if (one.has_model_id())
      served.promoted(one.model_id());
  }
  return served;
}

// Does the robot still do what it says? A sentence; empty: it does.
std::string doubt_about(const Connection& connection, std::int64_t id) {
  constexpr double kPatience_s = 120;
  v1::CheckModelRequest request;
  request.set_model_id(id);
  const std::string model = "model " + std::to_string(id);
  v1::CheckModelResponse check;
  try {
    check = connection.ask(&ModelStub::CheckModel, request, kPatience_s);
  } catch (const Failure& failure) {
    if (failure.exit == ExitCode::interrupted) throw;
    return model + " could not be checked against the runs since: " + failure.message;
  }
  if (check.verdict() == v1::CheckModelResponse::VERDICT_IN_CONTROL) return {};
  if (check.verdict() != v1::CheckModelResponse::VERDICT_RECALIBRATE)
    return "no run since " + model + " was made shows whether the robot still does what it says";
  std::string doubt =
      "the robot no longer does what " + model + " says (model check " + std::to_string(id) + ")";
  for (const auto& reason : check.reasons()) doubt += ": " + reason;
  return doubt;
}

// Consequences of putting it back.
std::vector<std::string> facts_of_return(const Connection& connection, std::int64_t id) {
  v1::GetModelRequest request;
  request.set_model_id(id);
  const auto page = connection.ask(&ModelStub::GetModel, request);
  std::vector<std::string> facts = {"model " + std::to_string(id) +
                                    " serves again: " + page.model().formula()};
  for (const auto& one : page.model().accuracy())
    facts.push_back("accuracy (A90) " + accuracy_text(one));
  for (const auto& question : page.promotion_questions()) facts.push_back("although " + question);
  if (auto doubt = doubt_about(connection, id); !doubt.empty()) facts.push_back(std::move(doubt));
  return facts;
}

ExitCode roll_back(const Session& session, bool yes) {
  const auto connection = session.connect();
  const auto serving = confirm_rollback(
      session.console, yes,
      served_models(connection.ask(&ModelStub::ListPromotions, v1::ListPromotionsRequest{})),
      {"model", "every target is refused (NO_MODEL)",
       [&](std::int64_t id) { return facts_of_return(connection, id); }});
  v1::RollBackModelRequest request;
  if (serving) request.set_serving_model_id(*serving);
  const auto response = connection.ask(&ModelStub::RollBackModel, request);
  return serving_now(session, response.has_model(), response.model());
}

ExitCode history(const Session& session) {
  const auto response =
      session.connect().ask(&ModelStub::ListPromotions, v1::ListPromotionsRequest{});
  if (session.console.json) {
    session.console.print_json(json_from(response));
    return ExitCode::done;
  }
  Table table({{"when (UTC)"}, {"action"}, {"model", Align::right}, {"by"}});
  for (const auto& promotion : response.promotions())
    table.add({clock_text(promotion.promote_time()),
               promotion.action() == v1::Promotion::ACTION_ROLLBACK ? "rollback" : "promote",
               promotion.has_model_id() ? std::to_string(promotion.model_id()) : "none",
               promotion.promoted_by()});
  table.print(session.console.out, session.console.paint_out());
  return ExitCode::done;
}

ExitCode export_model(const Session& session, const ModelArguments& a) {
  v1::ExportModelRequest request;
  request.set_model_id(a.id);
  request.set_format(a.format == "c" ? v1::ExportModelRequest::FORMAT_C
                                     : v1::ExportModelRequest::FORMAT_JSON);
  const auto response = session.connect().ask(&ModelStub::ExportModel, request);
  if (a.file.empty() || a.file == "-") {
    session.console.out << response.text() << std::flush;
    return ExitCode::done;
  }
  write_output_file(a.file, response.text());
  if (session.console.json)
    session.console.print_json({{"file", a.file}, {"bytes", response.text().size()}});
  else
    session.console.err << "wrote " << a.file << '\n';
  return ExitCode::done;
}

}  // namespace

void add_model_commands(CLI::App& app, Session& session) {
  CLI::App& model = *app.add_subcommand("model", "Fitted models, and which of them serves")
                         ->require_subcommand(1);
  auto a = std::make_shared<ModelArguments>();
  const auto id = [a](CLI::App& command) {
    command.add_option("MODEL", a->id, "number of the model")->required()->check(positive_number());
  };
  add_command(model, session, "list", "All models, oldest first",
              [&session] { return list(session); });
  id(add_command(model, session, "show", "One model as a page to sign",
                 [&session, a] { return show(session, a->id); }));
  CLI::App& comparing = add_command(
      model, session, "compare",
      "Several stored models side by side, term by term; or the methods on a dataset file or on "
      "runs",
      [&session, a] { return compare(session, *a); });
  comparing.add_option("MODEL|FILE", a->what, "numbers of the models, or one dataset CSV")
      ->expected(0, 16);
  comparing.add_option("--run", a->runs, "the methods on a run at the daemon; repeatable")
      ->allow_extra_args(false)
      ->check(positive_number());
  add_fit_options(comparing, a->fit);
  add_method_options(comparing, a->methods);
  comparing
      .add_option(
          "--methods", a->methods.methods,
          "of a file or a run: nominal, classic, kinematic, stepwise; else all that formula and "
          "geometry allow")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::IsMember({"stepwise", "classic", "kinematic", "nominal"}));
  CLI::App& promoting =
      add_command(model, session, "promote", "This model serves targets from now on",
                  [&session, a] { return promote(session, *a); });
  id(promoting);
  promoting.add_option("--reason", a->reason,
                       "why it serves although its campaign's wanted accuracy is not reached, or "
                       "nothing shows that it is: kept with the model");
  promoting.add_flag("--yes", a->yes, "ask nothing: for scripts");
  promoting.add_flag("--dry-run", a->dry_run, "say which model it would be, change nothing");
  add_import_command(model, session);
  add_check_command(model, session);
  add_sensors_command(model, session);
  add_grow_command(model, session);
  add_points_command(model, session);
  add_table_command(model, session);
  add_residuals_command(model, session);
  CLI::App& rolled =
      add_command(model, session, "rollback", "The model that served before serves again; asks",
                  [&session, a] { return roll_back(session, a->yes); });
  rolled.add_flag("--yes", a->yes, "ask nothing: for scripts");
  add_command(model, session, "history", "Every promotion and rollback",
              [&session] { return history(session); });
  CLI::App& out = add_command(model, session, "export",
                              "The model as JSON, or as a C function with test vectors",
                              [&session, a] { return export_model(session, *a); });
  id(out);
  out.add_option("--format", a->format, "json or c")
      ->check(CLI::IsMember({"json", "c"}))
      ->capture_default_str();
  out.add_option("-o,--output", a->file, "write this file instead of standard output");
}

}  // namespace driftwise::cli
