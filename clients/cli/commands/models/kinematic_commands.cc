#include "clients/cli/commands/models/kinematic_commands.h"

#include <memory>

#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/validators.h"
#include "clients/cli/pages/model_page.h"
#include "driftwise/v1/model_service.grpc.pb.h"

namespace driftwise::cli {
namespace {

struct ImportArguments {
  std::string file, data, name, note;
  bool joint_errors = false;
};

ExitCode import(const Session& session, const ImportArguments& a) {
  v1::CreateKinematicModelRequest request;
  request.set_robot_toml(read_input_file(a.file));
  if (!a.data.empty()) request.mutable_fit()->set_csv(read_input_file(a.data));
  request.mutable_fit()->set_name(a.name);
  request.mutable_fit()->set_note(a.note);
  request.set_with_joint_errors(a.joint_errors);
  return create_kinematic_model(session, request);
}

}  // namespace

void explain_fit_timeout(Failure& failure) {
  if (failure.reason != "TIMEOUT") return;
  failure.message +=
      ". The daemon continues without this program and may store the model: `driftwise model list` "
      "shows it";
}

void print_stored(const Console& console, const v1::Model& model, v1::CreateFitRequest asked) {
  clean_message(asked);  // as the answer was
  const bool other_name = !asked.name().empty() && asked.name() != model.name();
  const bool other_note = !asked.note().empty() && asked.note() != model.note();
  if (other_name || other_note)
    console.out << "this content was stored before as model " << model.id() << ", named '"
                << model.name() << "': not taken "
                << (other_name ? "the name '" + asked.name() + "'" : "")
                << (other_name && other_note ? " and " : "") << (other_note ? "the note" : "")
                << '\n';
  else
    console.out << "stored as model " << model.id() << '\n';
  console.err << "let it serve with `driftwise model promote " << model.id() << "`\n";
}

ExitCode create_kinematic_model(const Session& session,
                                const v1::CreateKinematicModelRequest& request) {
  const auto response =
      ask_for_fit(session.connect(), &v1::ModelService::Stub::CreateKinematicModel, request);
  if (session.console.json) {
    session.console.print_json(json_from(response));
    return ExitCode::done;
  }
  for (const auto& finding : response.findings()) session.console.out << finding << '\n';
  v1::GetModelResponse shown;
  *shown.mutable_model() = response.model();
  print_model_page(session.console, shown);
  print_stored(session.console, response.model(), request.fit());
  return ExitCode::done;
}

void add_import_command(CLI::App& model, Session& session) {
  auto a = std::make_shared<ImportArguments>();
  CLI::App& command = add_command(
      model, session, "import",
      "A robot file as a stored model of this cell's robot, as it is or identified on a dataset",
      [&session, a] { return import(session, *a); });
  command
      .add_option("ROBOT", a->file,
                  "robot file, such as diagnose --robot-out writes (docs/kinematics.md)")
      ->required();
  command.add_option("--data", a->data,
                     "dataset CSV that the robot file's numbers are identified on; without it "
                     "nothing judges the model");
  command.add_flag("--joint-errors", a->joint_errors,
                   "of an arm: first look for errors of its joints in the dataset");
  command.add_option("--name", a->name, "of the stored model");
  command.add_option("--note", a->note, "kept with the stored model");
}

}  // namespace driftwise::cli
