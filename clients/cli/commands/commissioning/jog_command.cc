#include <chrono>
#include <memory>
#include <thread>

#include "clients/cli/commands/commissioning/commissioning_commands.h"
#include "clients/cli/core/held_lease.h"
#include "clients/cli/core/hold_question.h"
#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/text.h"
#include "clients/cli/core/validators.h"
#include "driftwise/v1/commissioning_service.grpc.pb.h"

namespace driftwise::cli {
namespace {

using CommissioningStub = v1::CommissioningService::Stub;
using Steady = std::chrono::steady_clock;
constexpr std::chrono::milliseconds kSign{100};
constexpr double kStepLimit_s = 600;

struct JogArguments {
  std::string axis, step, lease_token;
  double hold_s = 0;
  HoldOptions hold;
};

std::string channel_of(const std::string& axis) {
  return axis.find('_') == std::string::npos ? axis + "_mm" : axis;
}

double position_of(const v1::Jog& jog, const std::string& channel) {
  for (const auto& one : jog.positions())
    if (one.channel() == channel) return one.position_mm();
  return 0;
}

ExitCode say(const Session& session, const v1::Jog& jog, const std::string& channel) {
  if (session.console.json)
    session.console.print_json(json_from(jog));
  else
    session.console.out << channel << " at " << fixed(position_of(jog, channel), 6) << " mm after "
                        << jog.step_count() << (jog.step_count() == 1 ? " step: " : " steps: ")
                        << jog.end_reason() << '\n';
  return jog.released() ? ExitCode::done : ExitCode::refused;
}

// A sign of life every 100 ms. The daemon stops the axis when they end, whatever ended them.
v1::Jog hold(const Connection& connection, v1::Jog jog, const std::string& token, double hold_s) {
  const auto until = Steady::now() + std::chrono::duration<double>(hold_s);
  while (!jog.over() && !connection.interrupted() && Steady::now() < until) {
    std::this_thread::sleep_for(kSign);
    v1::HoldJogRequest sign;
    sign.set_jog_id(jog.id());
    sign.set_lease_token(token);
    jog = connection.uninterrupted().ask(&CommissioningStub::HoldJog, sign).jog();
  }
  if (jog.over()) return jog;
  v1::EndJogRequest end;
  end.set_jog_id(jog.id());
  end.set_lease_token(token);
  return connection.uninterrupted().ask(&CommissioningStub::EndJog, end).jog();
}

ExitCode jog(const Session& session, const JogArguments& a) {
  const auto step = number_from(a.step.starts_with('+') ? a.step.substr(1) : a.step);
  if (!step)
    throw Failure{ExitCode::usage, "usage", "BAD_NUMBER",
                  "STEP: found '" + a.step + "', expected mm with a sign such as +0.001"};
  const auto connection = session.connect();
  v1::BeginJogRequest request;
  request.set_channel(channel_of(a.axis));
  request.set_step_mm(*step);
  request.set_held(a.hold_s > 0);
  *request.mutable_answer() =
      answer_about_present_run(session.console, connection, a.hold, "Jog the axis");
  const HeldLease lease(connection, a.lease_token);
  request.set_lease_token(lease.token());
  auto begun = connection.ask(&CommissioningStub::BeginJog, request, kStepLimit_s).jog();
  if (a.hold_s > 0) begun = hold(connection, std::move(begun), lease.token(), a.hold_s);
  return say(session, begun, request.channel());
}

}  // namespace

void add_jog_command(CLI::App& app, Session& session) {
  auto a = std::make_shared<JogArguments>();
  CLI::App& command = add_command(app, session, "jog", "Moves one axis by a step (takes the lease)",
                                  [&session, a] { return jog(session, *a); });
  command.add_option("AXIS", a->axis, "q1, or q1_mm")->required();
  command.add_option("STEP", a->step, "mm with its sign, at most 1: +0.001")->required();
  command
      .add_option("--hold", a->hold_s,
                  "step after step for so many seconds; the axis stops 300 ms after this program "
                  "is gone")
      ->check(number_between(0.1, 600));
  command.add_option("--lease-token", a->lease_token,
                     "of a lease taken with `driftwise lease take`");
  add_hold_options(command, a->hold);
}

}  // namespace driftwise::cli
