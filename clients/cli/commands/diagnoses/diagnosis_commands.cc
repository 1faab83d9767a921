#include "clients/cli/commands/diagnoses/diagnosis_commands.h"

#include <memory>

#include "clients/cli/core/confirm.h"
#include "clients/cli/core/job_bar.h"
#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "clients/cli/core/validators.h"
#include "driftwise/v1/diagnosis_service.grpc.pb.h"

namespace driftwise::cli {
namespace {

using DiagnosisStub = v1::DiagnosisService::Stub;

struct DiagnosisArguments {
  std::int64_t id = 0;
  std::vector<std::int32_t> findings;
  bool promote = false, yes = false;
  std::string file, reason;
};

v1::Diagnosis get(const Connection& connection, std::int64_t id) {
  v1::GetDiagnosisRequest request;
  request.set_diagnosis_id(id);
  return connection.ask(&DiagnosisStub::GetDiagnosis, request, 60).diagnosis();
}

// As `diagnose FILE --json` prints it, with what the record adds.
nlohmann::ordered_json whole_json(const v1::Diagnosis& diagnosis) {
  auto json = diagnosis.json().empty() ? nlohmann::ordered_json::object()
                                       : nlohmann::ordered_json::parse(diagnosis.json());
  v1::Diagnosis record = diagnosis;
  record.clear_json();
  record.clear_findings();
  record.clear_outputs();
  record.clear_not_testable();
  record.clear_left_over();
  record.clear_warnings();
  record.clear_separating_experiment();
  json["diagnosis"] = json_from(record);
  return json;
}

ExitCode show(const Session& session, const v1::Diagnosis& diagnosis) {
  if (session.console.json)
    session.console.print_json(whole_json(diagnosis));
  else
    print_diagnosis(session.console, diagnosis);
  switch (diagnosis.state()) {
    case v1::Diagnosis::STATE_CANCELLED:
    case v1::Diagnosis::STATE_FAILED:
      return ExitCode::refused;
    default:
      return diagnosis.verdict() == v1::VERDICT_UNEXPLAINED ? ExitCode::negative : ExitCode::done;
  }
}

// Until it is over. Ctrl-C cancels it: nobody would look at what it finds.
void follow(const Session& session, const Connection& connection, std::int64_t id) {
  v1::WatchDiagnosisRequest request;
  request.set_diagnosis_id(id);
  JobBar bar(session.console);
  try {
    connection.follow(&DiagnosisStub::WatchDiagnosis, request,
                      [&](const v1::WatchDiagnosisResponse& response) {
                        bar.show("diagnosis " + std::to_string(id), response.progress().fraction(),
                                 response.progress().step());
                        return true;
                      });
  } catch (Failure& failure) {
    if (failure.exit != ExitCode::interrupted) throw;
    v1::CancelDiagnosisRequest cancel;
    cancel.set_diagnosis_id(id);
    connection.uninterrupted().ask(&DiagnosisStub::CancelDiagnosis, cancel);
    failure.message = "interrupted: diagnosis " + std::to_string(id) + " is cancelled";
    throw;
  }
}

ExitCode list(const Session& session) {
  const auto response =
      session.connect().ask(&DiagnosisStub::ListDiagnoses, v1::ListDiagnosesRequest{}, 60);
  if (session.console.json) {
    session.console.print_json(json_from(response));
    return ExitCode::done;
  }
  Table table({{"diagnosis", Align::right},
               {"made (UTC)"},
               {"of"},
               {"baseline"},
               {"result"},
               {"accepted"}});
  for (const auto& one : response.diagnoses()) {
    std::string of;
    for (const auto run : one.run_ids()) of += (of.empty() ? "run " : ", ") + std::to_string(run);
    std::string found;
    for (const auto& finding : one.findings())
      found += (found.empty() ? "" : ", ") + cause_of(finding);
    if (one.state() == v1::Diagnosis::STATE_RUNNING) found = "running";
    if (one.state() == v1::Diagnosis::STATE_CANCELLED) found = "cancelled";
    if (one.state() == v1::Diagnosis::STATE_FAILED) found = "failed: " + one.reason();
    if (found.empty())
      found = one.verdict() == v1::VERDICT_UNEXPLAINED ? "unexplained" : "adequate";
    const bool stands = one.has_extension() && !one.extension().has_undo_time();
    table.add({std::to_string(one.id()), clock_text(one.create_time()), of.empty() ? "a file" : of,
               one.baseline_formula(), found,
               stands                ? "yes"
               : one.has_extension() ? "undone"
                                     : ""});
  }
  if (table.empty())
    session.console.out << "no diagnosis was made yet\n";
  else
    table.print(session.console.out, session.console.paint_out());
  return ExitCode::done;
}

ExitCode show_extension(const Session& session, const v1::Extension& extension) {
  if (session.console.json) {
    session.console.print_json(json_from(extension));
    return ExitCode::done;
  }
  print_diagnosis(session.console, get(session.connect(), extension.diagnosis_id()));
  return ExitCode::done;
}

v1::PreviewExtensionResponse previewed(const Connection& connection, const DiagnosisArguments& a) {
  v1::PreviewExtensionRequest request;
  request.set_diagnosis_id(a.id);
  for (const auto number : a.findings) request.add_finding_numbers(number);
  request.set_promote(a.promote);
  return connection.ask(&DiagnosisStub::PreviewExtension, request, 600);
}

std::vector<std::string> facts_of(const v1::PreviewExtensionResponse& preview) {
  std::vector<std::string> facts(preview.sentences().begin(), preview.sentences().end());
  for (const auto& question : preview.promotion_questions())
    facts.push_back("it would serve although " + question);
  return facts;
}

ExitCode preview(const Session& session, const DiagnosisArguments& a) {
  const auto response = previewed(session.connect(), a);
  if (session.console.json) {
    session.console.print_json(json_from(response));
    return ExitCode::done;
  }
  for (const auto& fact : facts_of(response)) session.console.out << fact << '\n';
  return ExitCode::done;
}

ExitCode accept(const Session& session, const DiagnosisArguments& a) {
  const auto connection = session.connect();
  const auto seen = previewed(connection, a);
  if (!seen.questions_for_a_reason().empty() && a.reason.empty())
    throw Failure{ExitCode::refused, "failed_precondition", "REASON_REQUIRED",
                  seen.questions_for_a_reason(0) +
                      ": say why it serves all the same, for the record: --reason 'TEXT'"};
  std::string numbers;
  for (const auto number : seen.finding_numbers())
    numbers += (numbers.empty() ? "" : ", ") + std::to_string(number);
  confirm(session.console, a.yes,
          "accepting finding " + numbers + " of diagnosis " + std::to_string(a.id) + ":",
          facts_of(seen), "Accept it");
  v1::AcceptExtensionRequest request;
  request.set_confirmed(true);  // the questions stood among the facts
  request.set_diagnosis_id(a.id);
  for (const auto number : a.findings) request.add_finding_numbers(number);
  request.set_promote(a.promote);
  request.set_reason(a.reason);
  return show_extension(session,
                        connection.ask(&DiagnosisStub::AcceptExtension, request, 600).extension());
}

ExitCode undo(const Session& session, std::int64_t id) {
  v1::UndoExtensionRequest request;
  request.set_diagnosis_id(id);
  return show_extension(
      session, session.connect().ask(&DiagnosisStub::UndoExtension, request, 60).extension());
}

ExitCode cancel(const Session& session, std::int64_t id) {
  v1::CancelDiagnosisRequest request;
  request.set_diagnosis_id(id);
  const auto cancelled =
      session.connect().ask(&DiagnosisStub::CancelDiagnosis, request).diagnosis();
  if (session.console.json)
    session.console.print_json(whole_json(cancelled));
  else
    print_diagnosis(session.console, cancelled);
  return ExitCode::done;
}

ExitCode export_page(const Session& session, const DiagnosisArguments& a) {
  v1::ExportDiagnosisRequest request;
  request.set_diagnosis_id(a.id);
  const auto page = session.connect().ask(&DiagnosisStub::ExportDiagnosis, request, 60);
  const std::string file = a.file.empty() ? page.file_name() : a.file;
  write_output_file(file, page.html());
  if (session.console.json)
    session.console.print_json({{"file", file}});
  else
    session.console.err << "wrote " << file << '\n';
  return ExitCode::done;
}

}  // namespace

ExitCode diagnose_runs(const Session& session, const DiagnoseRunArguments& a) {
  v1::CreateDiagnosisRequest request;
  for (const auto run : a.runs) request.add_run_ids(run);
  request.set_baseline(a.baseline);
  if (a.model != 0) request.set_model_id(a.model);
  request.set_alpha(a.alpha);
  request.set_seed(static_cast<std::int64_t>(a.seed));
  for (const auto& symbol : a.without) request.add_exclude_symbols(symbol);
  request.set_name(a.name);
  request.set_robot(a.robot);
  const auto connection = session.connect();
  const auto begun = connection.ask(&DiagnosisStub::CreateDiagnosis, request, 60).diagnosis();
  follow(session, connection, begun.id());
  return show(session, get(connection, begun.id()));
}

void add_diagnosis_commands(CLI::App& app, Session& session) {
  CLI::App& diagnosis = *app.add_subcommand("diagnosis", "What was found, and what is made of it")
                             ->require_subcommand(1);
  auto a = std::make_shared<DiagnosisArguments>();
  const auto id = [a](CLI::App& command) -> CLI::App& {
    command.add_option("DIAGNOSIS", a->id, "number of the diagnosis")
        ->required()
        ->check(positive_number());
    return command;
  };
  add_command(diagnosis, session, "list", "Diagnoses, newest first",
              [&session] { return list(session); });
  id(add_command(diagnosis, session, "show", "One diagnosis",
                 [&session, a] { return show(session, get(session.connect(), a->id)); }));
  CLI::App& accepted =
      id(add_command(diagnosis, session, "accept",
                     "Makes of findings a model, a correction of instruments, or rows kept out",
                     [&session, a] { return accept(session, *a); }));
  CLI::App& previewing =
      id(add_command(diagnosis, session, "preview",
                     "What accepting would change: which runs, from when, by how many nm",
                     [&session, a] { return preview(session, *a); }));
  for (CLI::App* one : {&accepted, &previewing}) {
    one->add_option("--finding", a->findings, "these, such as 1,3; else all")
        ->delimiter(',')
        ->check(positive_number());
    one->add_flag("--promote", a->promote, "the model that it makes serves at once");
  }
  accepted.add_flag("--yes", a->yes, "ask nothing: for scripts");
  accepted.add_option(
      "--reason", a->reason,
      "with --promote: why it serves although it misses the wanted accuracy; kept on "
      "record");
  id(add_command(diagnosis, session, "undo", "Takes back what accept made",
                 [&session, a] { return undo(session, a->id); }));
  id(add_command(diagnosis, session, "cancel", "Ends one that is under way",
                 [&session, a] { return cancel(session, a->id); }));
  id(add_command(diagnosis, session, "export", "The page of a diagnosis, one HTML file",
                 [&session, a] { return export_page(session, *a); }))
      .add_option("-o,--output", a->file, "file to write; else diagnosis_N.html");
}

}  // namespace driftwise::cli
