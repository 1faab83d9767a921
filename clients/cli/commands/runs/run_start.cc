#include "clients/cli/commands/runs/run_start.h"

#include <memory>
#include <random>

#include "clients/cli/commands/runs/run_watch.h"
#include "clients/cli/core/held_lease.h"
#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/trajectory_check.h"
#include "clients/cli/core/validators.h"
#include "clients/cli/pages/metadata_text.h"
#include "clients/cli/pages/run_text.h"
#include "driftwise/v1/cell_service.grpc.pb.h"

namespace driftwise::cli {
namespace {

struct StartArguments {
  std::string file, name, setup, lease_token, request_id;
  std::int64_t model = 0;
  int readings = 0;
  double max_spread_nm = 0;
  std::vector<std::string> meta;
  bool compensate = false, watch = false, dry_run = false;
};

// Makes a retry of this very call safe; gRPC may repeat one whose answer got lost.
std::string fresh_request_id() {
  std::random_device random;
  char text[40];
  std::snprintf(text, sizeof text, "cli-%08x%08x", random(), random());
  return text;
}

v1::CreateRunRequest request_from(const StartArguments& a, const std::string& text,
                                  const std::string& token) {
  v1::CreateRunRequest request;
  request.set_name(a.name.empty() ? base_name(a.file) : a.name);
  request.set_trajectory_name(base_name(a.file));
  request.set_trajectory_text(text);
  request.set_lease_token(token);
  request.set_request_id(a.request_id.empty() ? fresh_request_id() : a.request_id);
  request.set_setup(a.setup);
  request.set_compensate(a.compensate);
  if (a.model != 0) request.set_compensate_model_id(a.model);
  for (auto& item : metadata_from(a.meta)) *request.add_metadata() = std::move(item);
  if (a.readings != 0) request.mutable_rules()->set_readings_per_point(a.readings);
  if (a.max_spread_nm > 0) request.mutable_rules()->set_max_spread_nm(a.max_spread_nm);
  return request;
}

// The plan may be good all the same: a run begins, and waits for what does not answer.
void warn_of_silent_devices(const Console& console, const Connection& connection) {
  const auto status = connection.ask(&v1::CellService::Stub::GetStatus, v1::GetStatusRequest{});
  for (const auto& device : status.devices())
    if (device.link() != v1::Device::LINK_CONNECTED)
      console.err << console.paint_err().warn("warning: ") << "device '" << device.id() << "' at "
                  << device.address() << " does not answer"
                  << (device.last_error().empty() ? "" : " (" + device.last_error() + ")")
                  << ": a run that needs it would wait for it; look at its power and its cable\n";
}

ExitCode start(const Session& session, const StartArguments& a) {
  const std::string text = read_input_file(a.file);
  const auto connection = session.connect();
  const auto check = check_trajectory(connection, text, a.file);
  if (a.dry_run) {
    auto request = request_from(a, text, "");
    request.set_validate_only(true);
    connection.ask(&v1::RunService::Stub::CreateRun, request, 30.0);
    print_check(session.console, check, a.file);
    warn_of_silent_devices(session.console, connection);
    if (!session.console.json) session.console.err << "dry run: nothing was started\n";
    return ExitCode::done;
  }
  const HeldLease lease(connection, a.lease_token);
  for (const auto& warning : check.warnings())
    if (!session.console.json)
      session.console.err << session.console.paint_err().warn("warning: ") << warning << '\n';
  v1::Run run =
      connection.ask(&v1::RunService::Stub::CreateRun, request_from(a, text, lease.token()), 30.0)
          .run();
  if (!a.watch) {
    if (session.console.json)
      session.console.print_json(json_from(run));
    else {
      print_run(session.console, run);
      session.console.err << "follow it with `driftwise run watch " << run.id() << "`\n";
    }
    return ExitCode::done;
  }
  run = watch_until_over(session, connection, run.id());
  if (!session.console.json) print_run(session.console, run);
  return exit_code_of(run.state());
}

}  // namespace

void add_run_start(CLI::App& run, Session& session) {
  auto a = std::make_shared<StartArguments>();
  CLI::App& command =
      add_command(run, session, "start", "Starts a run of a trajectory (takes the lease to move)",
                  [&session, a] { return start(session, *a); });
  command.add_option("FILE", a->file, "trajectory CSV, - for standard input")->required();
  command.add_option("--name", a->name, "of the run; else the file's");
  auto* compensate =
      command.add_flag("--compensate", a->compensate,
                       "wanted poses: move to the serving model's targets, with several "
                       "robots to the serving plan's");
  command.add_option("--model", a->model, "compensate with this model instead")
      ->needs(compensate)
      ->check(positive_number());
  command.add_option("--setup", a->setup,
                     "[[setup]] of the cell file: only its instruments are read and required");
  command.add_option("--readings", a->readings, "readings per point instead of the cell's")
      ->check(number_between(2, 1000));
  command
      .add_option("--max-spread-nm", a->max_spread_nm,
                  "gate on their standard deviation instead of the cell's")
      ->check(positive_number());
  command.add_option("--meta", a->meta, "key=value for the run's record; may be repeated");
  command.add_flag("--watch", a->watch, "follow it to its end, the lease held meanwhile");
  command.add_flag("--dry-run", a->dry_run, "check only, start nothing");
  command.add_option("--lease-token", a->lease_token,
                     "of a lease taken with `driftwise lease take`");
  command.add_option("--request-id", a->request_id, "the same id again answers with the first run");
}

}  // namespace driftwise::cli
