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

ExitCode create_kinematic_model(const Session& session,
                                const v1::CreateKinematicModelRequest& request) {
  const auto response =
      session.connect().ask(&v1::ModelService::Stub::CreateKinematicModel, request);
  if (session.console.json) {
    session.console.print_json(json_from(response));
    return ExitCode::done;
  }
  for (const auto& finding : response.findings()) session.console.out << finding << '\n';
  v1::GetModelResponse shown;
  *shown.mutable_model() = response.model();
  print_model_page(session.console, shown);
  session.console.out << "stored as model " << response.model().id() << '\n';
  session.console.err << "let it serve with `driftwise model promote " << response.model().id()
                      << "`\n";
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
