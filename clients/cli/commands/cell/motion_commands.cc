#include <memory>

#include "clients/cli/commands/cell/cell_commands.h"
#include "clients/cli/core/assignment.h"
#include "clients/cli/core/held_lease.h"
#include "clients/cli/core/hold_question.h"
#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/text.h"
#include "clients/cli/core/validators.h"
#include "driftwise/v1/cell_service.grpc.pb.h"

namespace driftwise::cli {
namespace {

using CellStub = v1::CellService::Stub;
constexpr double kMotionLimit_s = 600;  // homing a slow axis

struct MotionArguments {
  std::vector<std::string> coordinates;
  std::string lease_token, device;
  double set_point_degc = 0, hold_s = 600;
  bool dry_run = false;
  HoldOptions hold;
};

ExitCode say(const Session& session, const std::string& done) {
  if (session.console.json)
    session.console.print_json({{"done", true}});
  else
    session.console.out << done << '\n';
  return ExitCode::done;
}

// What a dry run can know: the axes are there and the coordinates lie within their limits.
ExitCode dry_run(const Session& session, const v1::MoveRequest& request, const std::string& what) {
  const auto devices = session.connect().ask(&CellStub::ListDevices, v1::ListDevicesRequest{});
  for (const auto& value : request.coordinates()) {
    const v1::Axis* found = nullptr;
    for (const auto& device : devices.devices())
      for (const auto& axis : device.axes())
        if (axis.channel() == value.channel()) found = &axis;
    if (found == nullptr)
      throw Failure{ExitCode::bad_input, "invalid_argument", "UNKNOWN_AXIS",
                    "this cell has no axis " + value.channel()};
    if (value.value() < found->min_mm() || value.value() > found->max_mm())
      throw Failure{ExitCode::refused, "out_of_range", "OUTSIDE_LIMITS",
                    value.channel() + ": found " + significant(value.value(), 9) +
                        " mm, the soft limits are " + significant(found->min_mm(), 9) + " to " +
                        significant(found->max_mm(), 9) + " mm"};
  }
  if (session.console.json)
    session.console.print_json({{"done", false}, {"dry_run", true}});
  else
    session.console.out << "dry run: would " << what << '\n';
  return ExitCode::done;
}

ExitCode home(const Session& session, const MotionArguments& a) {
  if (a.dry_run) return dry_run(session, {}, "reference all axes; a new datum follows");
  const auto connection = session.connect();
  v1::HomeRequest request;
  *request.mutable_answer() =
      answer_about_present_run(session.console, connection, a.hold, "Reference the axes");
  const HeldLease lease(connection, a.lease_token);
  request.set_lease_token(lease.token());
  connection.ask(&CellStub::Home, request, kMotionLimit_s);
  return say(session, "homed");
}

ExitCode move(const Session& session, const MotionArguments& a) {
  v1::MoveRequest request;
  *request.mutable_coordinates() = assignments_from(a.coordinates);
  if (a.dry_run) return dry_run(session, request, "move there");
  const auto connection = session.connect();
  *request.mutable_answer() =
      answer_about_present_run(session.console, connection, a.hold, "Move the axes");
  const HeldLease lease(connection, a.lease_token);
  request.set_lease_token(lease.token());
  connection.ask(&CellStub::Move, request, kMotionLimit_s);
  return say(session, "moved");
}

ExitCode set_stabiliser(const Session& session, const MotionArguments& a) {
  const auto connection = session.connect();
  const HeldLease lease(connection, a.lease_token);
  v1::SetStabiliserRequest request;
  request.set_lease_token(lease.token());
  request.set_device_id(a.device);
  request.set_set_point_degc(a.set_point_degc);
  connection.ask(&CellStub::SetStabiliser, request, 30);
  return say(session, a.device + " set to " + fixed(a.set_point_degc, 3) + " degC");
}

ExitCode show_lease(const Session& session) {
  const auto status = session.connect().ask(&CellStub::GetStatus, v1::GetStatusRequest{});
  if (session.console.json) {
    session.console.print_json(
        {{"lease", status.has_lease() ? json_from(status.lease()) : nullptr}});
  } else if (status.has_lease()) {
    session.console.out << "held by " << status.lease().holder() << " (" << status.lease().peer()
                        << ") until " << clock_text(status.lease().end_time()) << " UTC\n";
  } else {
    session.console.out << "free\n";
  }
  return ExitCode::done;
}

ExitCode take_lease(const Session& session, const MotionArguments& a) {
  v1::TakeLeaseRequest request;
  request.mutable_lease_duration()->set_seconds(static_cast<std::int64_t>(a.hold_s));
  request.set_token(a.lease_token);
  const auto lease = session.connect().ask(&CellStub::TakeLease, request).lease();
  if (session.console.json)
    session.console.print_json(json_from(lease));
  else
    session.console.out << lease.token() << '\n';
  return ExitCode::done;
}

// A stop that is not confirmed is no success, although the daemon goes on with it.
ExitCode stop(const Session& session) {
  const auto answer = session.connect().ask(&CellStub::StopAll, v1::StopAllRequest{});
  if (!answer.confirmed())
    throw Failure{ExitCode::refused, "failed_precondition", "STOP_NOT_CONFIRMED", answer.message()};
  if (session.console.json)
    session.console.print_json(json_from(answer));
  else
    session.console.out << "stopped: " << answer.message() << '\n';
  return ExitCode::done;
}

}  // namespace

void add_motion_commands(CLI::App& app, Session& session) {
  auto a = std::make_shared<MotionArguments>();
  const auto lease_token = [a](CLI::App& command) {
    command.add_option("--lease-token", a->lease_token,
                       "of a lease taken with `driftwise lease take`");
  };
  add_command(app, session, "stop", "Halts all axes now and pauses a run under way; needs no lease",
              [&session] { return stop(session); });
  CLI::App& homing = add_command(app, session, "home", "References all axes (takes the lease)",
                                 [&session, a] { return home(session, *a); });
  lease_token(homing);
  homing.add_flag("--dry-run", a->dry_run, "say what would be done, move nothing");
  add_hold_options(homing, a->hold);
  CLI::App& moving =
      add_command(app, session, "move", "Moves to motor coordinates (takes the lease)",
                  [&session, a] { return move(session, *a); });
  moving.add_option("COORDINATE", a->coordinates, "q1=0.5 ..., in mm, every axis")->required();
  lease_token(moving);
  moving.add_flag("--dry-run", a->dry_run, "check the limits, move nothing");
  add_hold_options(moving, a->hold);
  CLI::App& stabiliser =
      add_command(app, session, "stabiliser", "Sets a temperature controller (takes the lease)",
                  [&session, a] { return set_stabiliser(session, *a); });
  stabiliser.add_option("DEVICE", a->device, "its id: support")->required();
  stabiliser.add_option("DEGC", a->set_point_degc, "set-point, degC")->required();
  lease_token(stabiliser);
  CLI::App& lease =
      *app.add_subcommand("lease", "Who may move: one client at a time")->require_subcommand(1);
  add_command(lease, session, "show", "Who holds it", [&session] { return show_lease(session); });
  CLI::App& take = add_command(lease, session, "take", "Takes or renews it and prints its token",
                               [&session, a] { return take_lease(session, *a); });
  take.add_option("--hold", a->hold_s, "seconds of cell time")
      ->check(number_between(1.0, 3600.0))
      ->capture_default_str();
  take.add_option("--renew", a->lease_token, "the token of a lease one holds");
  CLI::App& give_up = add_command(lease, session, "give-up", "Lets others move", [&session, a] {
    v1::GiveUpLeaseRequest request;
    request.set_token(a->lease_token);
    session.connect().ask(&CellStub::GiveUpLease, request);
    return say(session, "given up");
  });
  give_up.add_option("TOKEN", a->lease_token, "as `lease take` printed it")->required();
}

}  // namespace driftwise::cli
