#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <sstream>
#include <thread>

#include "clients/cli/commands/cell/cell_commands.h"
#include "clients/cli/core/assignment.h"
#include "clients/cli/core/confirm.h"
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
  double hold_s = 600;
  std::optional<double> set_point_degc, heat_band_k, cool_band_k, integral_s, derivative_s;
  bool dry_run = false, yes = false;
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

struct TuningLine {
  const char *name, *unit;
  std::optional<double> before, after;
};

google::protobuf::Duration duration_of(double seconds) {
  google::protobuf::Duration duration;
  const double whole_s = std::floor(seconds);
  duration.set_seconds(static_cast<std::int64_t>(whole_s));
  duration.set_nanos(static_cast<std::int32_t>(std::lround(1e9 * (seconds - whole_s))));
  return duration;
}

std::optional<double> seconds_of(bool has, const google::protobuf::Duration& duration) {
  if (!has) return std::nullopt;
  return static_cast<double>(duration.seconds()) + 1e-9 * duration.nanos();
}

// Values of the controller beside what it is to have or what the cell file declares.
std::vector<TuningLine> tuning_lines(const v1::StabiliserTuning& a, const v1::StabiliserTuning& b) {
  const auto band = [](bool has, double k) { return has ? std::optional(k) : std::nullopt; };
  return {
      {"heat band", "K", band(a.has_heat_band_k(), a.heat_band_k()),
       band(b.has_heat_band_k(), b.heat_band_k())},
      {"cool band", "K", band(a.has_cool_band_k(), a.cool_band_k()),
       band(b.has_cool_band_k(), b.cool_band_k())},
      {"integral", "s", seconds_of(a.has_integral_duration(), a.integral_duration()),
       seconds_of(b.has_integral_duration(), b.integral_duration())},
      {"derivative", "s", seconds_of(a.has_derivative_duration(), a.derivative_duration()),
       seconds_of(b.has_derivative_duration(), b.derivative_duration())},
  };
}

void print_tuning(std::ostream& out, const std::vector<TuningLine>& lines, const char* second) {
  for (const auto& line : lines) {
    out << "  " << line.name << ": " << (line.before ? significant(*line.before, 6) : "-") << ' '
        << line.unit;
    if (line.after) out << second << significant(*line.after, 6) << ' ' << line.unit;
    out << '\n';
  }
}

ExitCode show_stabiliser(const Session& session, const Connection& connection,
                         const v1::GetStabiliserResponse& now, const std::string& device) {
  const auto status = connection.ask(&CellStub::GetStatus, v1::GetStatusRequest{});
  if (session.console.json) {
    session.console.print_json(json_from(now));
    return ExitCode::done;
  }
  auto& out = session.console.out;
  out << device << ", settled within " << significant(1000 * now.settled_band_k(), 4) << " mK\n";
  std::string stem = device + '_';
  std::ranges::replace(stem, '-', '_');
  for (const auto& value : status.values())
    if (value.channel().starts_with(stem) && value.has_value())
      out << "  " << value.channel() << ": " << significant(value.value(), 7) << '\n';
  print_tuning(out, tuning_lines(now.tuning(), now.declared()), ", declared ");
  for (const auto& difference : now.differences())
    out << "  not as declared: " << difference << '\n';
  return ExitCode::done;
}

ExitCode tune_stabiliser(const Session& session, const Connection& connection,
                         const v1::GetStabiliserResponse& now, const MotionArguments& a) {
  v1::TuneStabiliserRequest request;
  auto& wanted = *request.mutable_tuning();
  if (a.heat_band_k) wanted.set_heat_band_k(*a.heat_band_k);
  if (a.cool_band_k) wanted.set_cool_band_k(*a.cool_band_k);
  if (a.integral_s) *wanted.mutable_integral_duration() = duration_of(*a.integral_s);
  if (a.derivative_s) *wanted.mutable_derivative_duration() = duration_of(*a.derivative_s);
  const auto lines = tuning_lines(now.tuning(), wanted);
  if (a.dry_run) {
    if (!session.console.json) print_tuning(session.console.out, lines, " -> ");
    return say(session, "dry run: would set them");
  }
  std::ostringstream facts;
  print_tuning(facts, lines, " -> ");
  confirm(session.console, a.yes, a.device + ": the controller's loop", {facts.str()},
          "Set it now");
  const HeldLease lease(connection, a.lease_token);
  request.set_lease_token(lease.token());
  request.set_device_id(a.device);
  const auto tuned = connection.ask(&CellStub::TuneStabiliser, request, 30);
  if (session.console.json) {
    session.console.print_json(json_from(tuned));
    return ExitCode::done;
  }
  session.console.out << a.device << " has now\n";
  print_tuning(session.console.out, tuning_lines(tuned.after(), {}), "");
  return ExitCode::done;
}

// Without anything to set: what the controller has.
ExitCode stabiliser(const Session& session, const MotionArguments& a) {
  const auto connection = session.connect();
  const bool tunes = a.heat_band_k || a.cool_band_k || a.integral_s || a.derivative_s;
  if (a.set_point_degc && tunes)
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  "give a set-point or control parameters: each is set and recorded by itself"};
  if (!a.set_point_degc) {
    v1::GetStabiliserRequest request;
    request.set_device_id(a.device);
    const auto now = connection.ask(&CellStub::GetStabiliser, request, 30);
    return tunes ? tune_stabiliser(session, connection, now, a)
                 : show_stabiliser(session, connection, now, a.device);
  }
  const HeldLease lease(connection, a.lease_token);
  v1::SetStabiliserRequest request;
  request.set_lease_token(lease.token());
  request.set_device_id(a.device);
  request.set_set_point_degc(*a.set_point_degc);
  connection.ask(&CellStub::SetStabiliser, request, 30);
  return say(session, a.device + " set to " + fixed(*a.set_point_degc, 3) + " degC");
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

// Whether every controller reports no motion within the time that an axis needs to slow down, some
// ten milliseconds more than the daemon's answer waits for.
bool is_confirmed_late(const Connection& connection) {
  constexpr std::chrono::milliseconds kSlowingDown{1000}, kBetween{50};
  const auto until = std::chrono::steady_clock::now() + kSlowingDown;
  while (std::chrono::steady_clock::now() < until) {
    std::this_thread::sleep_for(kBetween);
    const auto status = connection.ask(&CellStub::GetStatus, v1::GetStatusRequest{}, 1);
    if (status.pending_stops().empty()) return true;
  }
  return false;
}

// A stop that is not confirmed is said so at once, and is no success, although the daemon goes on
// with it.
ExitCode stop(const Session& session) {
  constexpr double kPatience_s = 3;  // the daemon answers within 0.1 s
  const auto connection = session.connect_for_halting("STOPPED");
  auto answer = connection.ask(&CellStub::StopAll, v1::StopAllRequest{}, kPatience_s);
  if (!answer.confirmed()) {
    session.console.err << "driftwise: " << answer.message() << std::endl;
    if (!is_confirmed_late(connection))
      throw Failure{ExitCode::refused, "failed_precondition", "STOP_NOT_CONFIRMED",
                    answer.message()};
    answer.set_confirmed(true);
    answer.clear_pending();
    answer.set_message("every controller reports no motion now");
  }
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
  CLI::App& loop = add_command(
      app, session, "stabiliser",
      "A temperature controller: shows it, sets its set-point or its loop (takes the lease)",
      [&session, a] { return stabiliser(session, *a); });
  loop.add_option("DEVICE", a->device, "its id: support")->required();
  loop.add_option("DEGC", a->set_point_degc, "set-point, degC");
  loop.add_option("--heat-band", a->heat_band_k, "proportional band of heating, K");
  loop.add_option("--cool-band", a->cool_band_k, "proportional band of cooling, K");
  loop.add_option("--integral", a->integral_s, "integral time, s; 0: off");
  loop.add_option("--derivative", a->derivative_s, "derivative time, s; 0: off");
  for (const char* option : {"--heat-band", "--cool-band", "--integral", "--derivative"})
    loop.get_option(option)->check(finite_number());
  loop.add_flag("--dry-run", a->dry_run, "show before and after, set nothing");
  loop.add_flag("-y,--yes", a->yes, "set it without asking");
  lease_token(loop);
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
