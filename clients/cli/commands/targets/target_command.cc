#include "clients/cli/commands/targets/target_command.h"

#include <memory>

#include "clients/cli/commands/targets/arm_target.h"
#include "clients/cli/commands/targets/target_map_command.h"
#include "clients/cli/core/assignment.h"
#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "clients/cli/core/validators.h"
#include "clients/cli/pages/budget_table.h"
#include "driftwise/v1/commissioning_service.grpc.pb.h"
#include "driftwise/v1/target_service.grpc.pb.h"

namespace driftwise::cli {
namespace {

using TargetStub = v1::TargetService::Stub;

struct TargetArguments {
  std::vector<std::string> pose, near;
  std::string kinematics;
  double every_s = 0;
  bool budget = false, watch = false;
};

std::string lower(std::string name, std::string_view prefix) {
  name.erase(0, prefix.size());
  for (char& c : name)
    c = c == '_' ? ' ' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return name;
}

std::string joined(const google::protobuf::RepeatedPtrField<std::string>& names) {
  std::string out;
  for (const auto& name : names) out += (out.empty() ? "" : ", ") + name;
  return out;
}

std::string unreachable_text(const v1::Target& target) {
  std::string out = "not reachable:";
  const char* separator = " ";
  for (const auto& one : target.coordinates()) {
    if (!one.has_min_mm() && !one.joint().has_min()) continue;
    const bool joint = one.has_joint();
    out += separator + one.channel() + " has soft limits " +
           significant(joint ? one.joint().min() : one.min_mm(), 6) + " .. " +
           significant(joint ? one.joint().max() : one.max_mm(), 6);
    separator = ", ";
  }
  return out;
}

bool reachable(const v1::Target& target) { return target.unreachable_channels().empty(); }

}  // namespace

void print_flags(const Console& console, const v1::Target& target) {
  const Paint paint = console.paint_out();
  for (const int flag : target.flags()) {
    std::string line = lower(v1::Target::Flag_Name(static_cast<v1::Target::Flag>(flag)), "FLAG_");
    if (flag == v1::Target::FLAG_OUTSIDE_DOMAIN) line += ": " + joined(target.outside_channels());
    if (flag == v1::Target::FLAG_ZERO_OUTSIDE_DOMAIN)
      line += ": " + joined(target.zero_outside_channels()) +
              " (the zero of this datum was taken outside what the model was fitted on: take it "
              "again within it)";
    if (flag == v1::Target::FLAG_STALE_TEMPERATURE) line += ": " + joined(target.stale_channels());
    if (flag == v1::Target::FLAG_MISSING_TEMPERATURE)
      line += ": " + joined(target.missing_channels());
    if (flag == v1::Target::FLAG_UNKNOWN_LIMITS)
      line += ": " + joined(target.unlimited_channels()) +
              " (the cell file has no such axis, so nothing says whether it can be reached)";
    if (flag == v1::Target::FLAG_IGNORED_COORDINATE)
      line += ": the model does not depend on " + joined(target.ignored_channels());
    if (flag == v1::Target::FLAG_OUTSIDE_LIMITS && target.coordinates_size() > 0)
      line = unreachable_text(target);
    if (flag == v1::Target::FLAG_UNJUDGED_MODEL)
      line += ": no data judged it, so neither its domain nor its uncertainty is known";
    if (flag == v1::Target::FLAG_DOUBTFUL_MODEL)
      line +=
          ": the robot no longer does what it says (driftwise model check), so the error may "
          "exceed the uncertainty: recalibrate";
    console.out << paint.warn("! ") << line << '\n';
  }
}

namespace {

// Of an arm.
void print_joints(const Console& console, const v1::Target& target) {
  Table table({{"joint"},
               {"angle", Align::right},
               {"u arcsec", Align::right},
               {"U90 arcsec", Align::right},
               {"U (k=2) arcsec", Align::right}});
  const auto known = [](bool has, double value) { return has ? fixed(value, 2) : "-"; };
  for (const auto& coordinate : target.coordinates()) {
    const auto& joint = coordinate.joint();
    table.add({coordinate.channel() + (joint.has_min() ? " (not reachable)" : ""),
               fixed(joint.position(), 9), known(joint.has_u_arcsec(), joint.u_arcsec()),
               known(joint.has_u90_arcsec(), joint.u90_arcsec()),
               known(joint.has_expanded_arcsec(), joint.expanded_arcsec())});
  }
  table.print(console.out, console.paint_out());
}

void print_conditions(const Console& console, const v1::Target& target) {
  console.out << "model " << target.model_id() << ", conditions of "
              << clock_text(target.conditions_time()) << " UTC, valid until "
              << utc_text(target.valid_until_time()).substr(11) << '\n';
  print_flags(console, target);
}

// For people: a table of coordinates, what the model adds in nm, uncertainty, then flags.
void print_target(const Console& console, const v1::Target& target) {
  if (target.coordinates_size() > 0 && target.coordinates(0).has_joint()) {
    print_joints(console, target);
    print_budget(console, target.coordinates());
    return print_conditions(console, target);
  }
  Table table({{"coordinate"},
               {"mm", Align::right},
               {"correction nm", Align::right},
               {"u nm", Align::right},
               {"U90 nm", Align::right},
               {"U (k=2) nm", Align::right}});
  for (const auto& coordinate : target.coordinates()) {
    const std::string channel = coordinate.channel().substr(0, coordinate.channel().rfind('_'));
    table.add({channel + (coordinate.has_min_mm() ? " (not reachable)" : ""),
               fixed(coordinate.position_mm(), 7),
               coordinate.has_correction_nm() ? signed_fixed(coordinate.correction_nm(), 1) : "-",
               fixed(coordinate.u_nm(), 1), fixed(coordinate.u90_nm(), 1),
               fixed(coordinate.expanded_nm(), 1)});
  }
  table.print(console.out, console.paint_out());
  print_budget(console, target.coordinates());
  print_conditions(console, target);
}

// Declared uncertainties stand on them.
void print_certificates(const Console& console, const Connection& connection) {
  const auto response = connection.ask(&v1::CommissioningService::Stub::ListCertificates,
                                       v1::ListCertificatesRequest{});
  for (const auto& one : response.certificates())
    console.out << "certificate of " << one.device_id() << ": " << one.number() << ", "
                << one.laboratory() << ", " << one.date()
                << (one.due_date().empty() ? "" : ", due " + one.due_date())
                << (one.has_days_left() && one.days_left() < 0
                        ? console.paint_out().bad(" (overdue)")
                        : "")
                << '\n';
}

// The daemon's model says the joints' unit, the request has to.
google::protobuf::RepeatedPtrField<v1::ChannelValue> angles_from(
    const std::vector<std::string>& texts) {
  auto angles = assignments_from(texts);
  for (const auto& angle : angles)
    if (!angle.channel().ends_with("_rad") && !angle.channel().ends_with("_deg"))
      throw Failure{ExitCode::usage, "usage", "USAGE",
                    "--near: found " + angle.channel() +
                        ", expected joint angles with their unit, such as q2_deg=-90"};
  return angles;
}

ExitCode ask_once(const Session& session, const v1::ComputeTargetRequest& request) {
  const auto connection = session.connect();
  const auto target = connection.ask(&TargetStub::ComputeTarget, request).target();
  if (session.console.json) {
    session.console.print_json(json_from(target));
  } else {
    print_target(session.console, target);
    if (request.with_budget()) print_certificates(session.console, connection);
  }
  return reachable(target) ? ExitCode::done : ExitCode::negative;
}

ExitCode follow(const Session& session, const v1::ComputeTargetRequest& asked, double every_s) {
  v1::WatchTargetsRequest request;
  *request.mutable_pose() = asked.pose();
  *request.mutable_near() = asked.near();
  request.set_show_unreachable(true);
  if (every_s > 0) {
    request.mutable_min_interval_duration()->set_seconds(static_cast<std::int64_t>(every_s));
    request.mutable_min_interval_duration()->set_nanos(static_cast<std::int32_t>(
        (every_s - static_cast<double>(static_cast<std::int64_t>(every_s))) * 1e9));
  }
  session.connect().follow(
      &TargetStub::WatchTargets, request, [&](const v1::WatchTargetsResponse& response) {
        const auto& target = response.target();
        if (session.console.json) {
          session.console.out << json_from(target).dump() << '\n' << std::flush;
          return true;
        }
        session.console.out << utc_text(target.conditions_time());
        for (const auto& coordinate : target.coordinates())
          if (coordinate.has_joint())
            session.console.out << "  " << coordinate.channel() << " "
                                << fixed(coordinate.joint().position(), 9)
                                << (coordinate.joint().has_min() ? " not reachable" : "");
          else
            session.console.out << "  " << coordinate.channel() << " "
                                << fixed(coordinate.position_mm(), 7) << "  U90 "
                                << fixed(coordinate.u90_nm(), 1) << " nm"
                                << (coordinate.has_min_mm() ? " not reachable" : "");
        for (const int flag : target.flags())
          session.console.out << "  "
                              << lower(v1::Target::Flag_Name(static_cast<v1::Target::Flag>(flag)),
                                       "FLAG_");
        session.console.out << '\n' << std::flush;
        return true;
      });
  return ExitCode::done;
}

}  // namespace

void add_target_command(CLI::App& app, Session& session) {
  auto a = std::make_shared<TargetArguments>();
  CLI::App& command =
      *app.add_subcommand("target", "Compensated motor coordinates of a pose; moves nothing");
  command.require_subcommand(0, 1);
  command.callback([&session, &command, a] {
    if (!command.get_subcommands().empty()) return;
    session.action = [&session, a] {
      if (a->pose.empty())
        throw Failure{ExitCode::usage, "usage", "USAGE",
                      "target of which pose? give it: driftwise target x=1.5"};
      if (!a->kinematics.empty()) {
        if (a->budget || a->watch)
          throw Failure{ExitCode::usage, "usage", "USAGE",
                        std::string(a->budget ? "--budget" : "--watch") +
                            " asks the daemon, --kinematics asks a robot file: leave one of the "
                            "two out"};
        return arm_target(session, {a->kinematics, a->pose, a->near});
      }
      v1::ComputeTargetRequest request;
      *request.mutable_pose() = assignments_from(a->pose);
      request.set_with_budget(a->budget);
      request.set_show_unreachable(true);
      *request.mutable_near() = angles_from(a->near);
      return a->watch ? follow(session, request, a->every_s) : ask_once(session, request);
    };
  });
  command.add_option("POSE", a->pose, "x=1.5 ..., mm, arcsec, N");
  command.add_option(
      "--kinematics", a->kinematics,
      "of a serial arm, without a daemon: robot file, such as diagnose --robot-out writes");
  command
      .add_option("--near", a->near,
                  "q1_deg=20,...: of an arm's solutions the nearest to these angles; else to where "
                  "the joints stand")
      ->delimiter(',');
  command.add_flag("--budget", a->budget, "what the uncertainty is made of");
  auto* watch =
      command.add_flag("--watch", a->watch, "again whenever the conditions change, one line each");
  command.add_option("--every", a->every_s, "at least so many seconds between two lines")
      ->needs(watch)
      ->check(number_between(0.0, 86400.0));
  add_target_map_command(command, session);
}

}  // namespace driftwise::cli
