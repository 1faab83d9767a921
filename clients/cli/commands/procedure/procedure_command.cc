#include "clients/cli/commands/procedure/procedure_command.h"

#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/text.h"
#include "driftwise/v1/study_service.grpc.pb.h"

namespace driftwise::cli {
namespace {

const char* state_text(v1::ProcedureStep::State state) {
  return state == v1::ProcedureStep::STATE_DONE   ? "done"
         : state == v1::ProcedureStep::STATE_OPEN ? "open"
                                                  : "not reached";
}

nlohmann::ordered_json step_json(const v1::ProcedureStep& step) {
  nlohmann::ordered_json json{
      {"step", step.number()}, {"name", step.name()},       {"state", state_text(step.state())},
      {"found", step.found()}, {"missing", step.missing()}, {"command", step.command()}};
  const auto optional = [](bool has, auto value) {
    return has ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
  };
  if (!step.sources().empty()) json["sources"] = nlohmann::ordered_json::array();
  for (const auto& source : step.sources())
    json["sources"].push_back({{"name", source.name()},
                               {"considered", source.considered()},
                               {"measured_by", source.measured_by()}});
  if (!step.figures().empty()) json["figures"] = nlohmann::ordered_json::array();
  for (const auto& figure : step.figures())
    json["figures"].push_back(
        {{"coordinate", figure.coordinate()},
         {"unit", figure.unit()},
         {"a90", optional(figure.has_a90(), figure.a90())},
         {"wanted_a90", optional(figure.has_wanted_a90(), figure.wanted_a90())}});
  if (step.has_back_to_step()) json["back_to_step"] = step.back_to_step();
  if (step.has_largest_u_nm()) {
    json["largest_line"] = step.largest_line();
    json["largest_u_nm"] = step.largest_u_nm();
  }
  return json;
}

void print_steps(const Console& console, const v1::GetProcedureResponse& procedure) {
  const Paint paint = console.paint_out();
  for (const auto& step : procedure.steps()) {
    const std::string text = state_text(step.state());
    const std::string state = step.state() == v1::ProcedureStep::STATE_DONE   ? paint.good(text)
                              : step.state() == v1::ProcedureStep::STATE_OPEN ? paint.warn(text)
                                                                              : paint.bad(text);
    console.out << paint.bold(std::to_string(step.number()) + "  " + step.name()) << ": " << state
                << '\n';
    for (const auto* line : {&step.found(), &step.missing()})
      if (!line->empty()) console.out << "   " << *line << '\n';
    if (!step.command().empty()) console.out << "   > " << step.command() << '\n';
  }
}

ExitCode show_procedure(const Session& session) {
  const auto procedure =
      session.connect().ask(&v1::StudyService::Stub::GetProcedure, v1::GetProcedureRequest{});
  if (session.console.json) {
    nlohmann::ordered_json json{{"schema", "driftwise.procedure.v1"}};
    json["steps"] = nlohmann::ordered_json::array();
    for (const auto& step : procedure.steps()) json["steps"].push_back(step_json(step));
    session.console.print_json(json);
  } else {
    print_steps(session.console, procedure);
  }
  // The last step says whether the wanted accuracy is reached; nothing wanted is not reached.
  const bool reached = !procedure.steps().empty() &&
                       procedure.steps().rbegin()->state() == v1::ProcedureStep::STATE_DONE;
  return reached ? ExitCode::done : ExitCode::negative;
}

}  // namespace

void add_procedure_command(CLI::App& app, Session& session) {
  add_command(app, session, "procedure",
              "The whole procedure, steps 0 to 5: what is done, what is missing, where to go back",
              [&session] { return show_procedure(session); });
}

}  // namespace driftwise::cli
