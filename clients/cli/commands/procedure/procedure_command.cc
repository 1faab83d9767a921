#include "clients/cli/commands/procedure/procedure_command.h"

#include <algorithm>
#include <charconv>

#include "clients/cli/commands/procedure/procedure_steps.h"
#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/text.h"
#include "clients/cli/pages/budget_table.h"
#include "driftwise/v1/cell_service.grpc.pb.h"
#include "driftwise/v1/model_service.grpc.pb.h"
#include "driftwise/v1/run_service.grpc.pb.h"

namespace driftwise::cli {
namespace {

using CellStub = v1::CellService::Stub;
using RunStub = v1::RunService::Stub;
using ModelStub = v1::ModelService::Stub;

void look_at_devices(const Connection& connection, ProcedureFacts& facts) {
  bool lengths = false, angles = false, force = false, robot = false, air = false, bench = false;
  const auto response = connection.ask(&CellStub::ListDevices, v1::ListDevicesRequest{});
  for (const auto& device : response.devices()) {
    lengths = lengths || !device.length_channel().empty();
    angles = angles || !device.angle_channels().empty();
    force = force || !device.force_channel().empty();
    for (const auto& probe : device.probes()) {
      robot = robot || probe.part() == "robot";
      air = air || probe.part() == "air";
      bench = bench || probe.part() == "instrument";
    }
  }
  facts.sources = {{"geometry (lengths)", lengths},
                   {"parasitic rotations", angles},
                   {"temperatures of the robot", robot},
                   {"temperatures of the instruments", bench},
                   {"air", air},
                   {"process force", force}};
}

void look_at_runs(const Connection& connection, ProcedureFacts& facts) {
  v1::ListRunsRequest request;
  request.set_limit(200);
  const auto listed = connection.ask(&RunStub::ListRuns, request);
  for (const auto& run : listed.runs()) {
    facts.runs.push_back({.id = run.id(),
                          .setup = run.setup(),
                          .done = run.state() == v1::Run::STATE_DONE,
                          .compensated = run.compensated(),
                          .points = run.accepted_count()});
    if (run.compensated() && run.state() == v1::Run::STATE_DONE && !facts.verified_run)
      facts.verified_run = run.id();
    if (facts.campaign) continue;
    for (const auto& item : run.metadata()) {
      if (!item.key().starts_with(kWantedPrefix)) continue;
      double a90 = 0;
      const auto& text = item.value();
      const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), a90);
      if (error != std::errc() || end != text.data() + text.size() || !(a90 > 0))
        throw Failure{ExitCode::bad_input, "invalid_argument", "BAD_NUMBER",
                      "run " + std::to_string(run.id()) + " states " + item.key() + "=" + text +
                          ", expected a number above 0: driftwise run tag " +
                          std::to_string(run.id()) + " " + item.key() + "=100"};
      facts.wanted.push_back({item.key().substr(std::string(kWantedPrefix).size()), a90});
    }
    if (!facts.wanted.empty()) facts.campaign = run.id();
  }
}

void look_at_models(const Connection& connection, ProcedureFacts& facts) {
  const auto models = connection.ask(&ModelStub::ListModels, v1::ListModelsRequest{});
  const v1::Model* chosen = nullptr;
  for (const auto& model : models.models())
    if (chosen == nullptr || model.serving() || !chosen->serving()) chosen = &model;
  if (chosen == nullptr) return;
  ProcedureFacts::Model facts_of{.id = chosen->id(),
                                 .serving = chosen->serving(),
                                 .validation_rows = chosen->lineage().validation_row_count(),
                                 .accuracy = {},
                                 .largest_line = {}};
  for (const auto& one : chosen->accuracy())
    facts_of.accuracy.push_back({one.output(), one.unit(), one.figures().a90()});
  v1::GetModelRequest request;
  request.set_model_id(chosen->id());
  double largest_nm = 0;
  const auto shown = connection.ask(&ModelStub::GetModel, request);
  for (const auto& budget : shown.budgets())
    for (const auto& coordinate : budget.coordinates())
      for (const auto& line : coordinate.budget()) {
        if (line.u_nm() <= largest_nm) continue;
        largest_nm = line.u_nm();
        facts_of.largest_line = budget_line_name(line) + " " + fixed(line.u_nm(), 1) + " nm";
        facts_of.largest_is_measured = line.source() == v1::BudgetLine::SOURCE_FIT ||
                                       line.source() == v1::BudgetLine::SOURCE_RESIDUAL;
      }
  facts.model = std::move(facts_of);
}

void look_at_verification(const Connection& connection, ProcedureFacts& facts) {
  if (!facts.verified_run) return;
  v1::VerifyRunsRequest request;
  request.add_run_ids(*facts.verified_run);
  const auto response = connection.ask(&RunStub::VerifyRuns, request);
  for (const auto& run : response.runs())
    for (const auto& one : run.coordinates())
      facts.verified.push_back({one.coordinate(), one.unit(), one.all().a90()});
}

nlohmann::ordered_json steps_json(const std::vector<ProcedureStep>& steps) {
  nlohmann::ordered_json json{{"schema", "driftwise.procedure.v1"}};
  json["steps"] = nlohmann::ordered_json::array();
  for (const auto& step : steps)
    json["steps"].push_back({{"step", step.number},
                             {"name", step.name},
                             {"state", step.state},
                             {"found", step.found},
                             {"missing", step.missing},
                             {"command", step.command}});
  return json;
}

void print_steps(const Console& console, const std::vector<ProcedureStep>& steps) {
  const Paint paint = console.paint_out();
  for (const auto& step : steps) {
    const std::string state = step.state == "done"   ? paint.good(step.state)
                              : step.state == "open" ? paint.warn(step.state)
                                                     : paint.bad(step.state);
    console.out << paint.bold(std::to_string(step.number) + "  " + step.name) << ": " << state
                << '\n';
    for (const auto* line : {&step.found, &step.missing})
      if (!line->empty()) console.out << "   " << *line << '\n';
    if (!step.command.empty()) console.out << "   > " << step.command << '\n';
  }
}

ExitCode show_procedure(const Session& session) {
  const auto connection = session.connect();
  ProcedureFacts facts;
  look_at_devices(connection, facts);
  look_at_runs(connection, facts);
  look_at_models(connection, facts);
  look_at_verification(connection, facts);
  const auto steps = procedure_steps(facts);
  if (session.console.json)
    session.console.print_json(steps_json(steps));
  else
    print_steps(session.console, steps);
  const bool missed = std::ranges::any_of(
      steps, [](const ProcedureStep& step) { return step.state == "not reached"; });
  return missed ? ExitCode::negative : ExitCode::done;
}

}  // namespace

void add_procedure_command(CLI::App& app, Session& session) {
  add_command(app, session, "procedure",
              "The whole procedure, steps 0 to 5: what is done, what is missing, where to go back",
              [&session] { return show_procedure(session); });
}

}  // namespace driftwise::cli
