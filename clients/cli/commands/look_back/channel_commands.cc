#include <cmath>
#include <memory>

#include "clients/cli/commands/look_back/look_back_commands.h"
#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "clients/cli/core/validators.h"
#include "driftwise/v1/cell_service.grpc.pb.h"
#include "driftwise/v1/look_back_service.grpc.pb.h"

namespace driftwise::cli {
namespace {

struct ChannelArguments {
  std::string channel;
  double hours = 1, ago_h = 0;
};

v1::AnalyseStabilityResponse ask(const Session& session, const ChannelArguments& a) {
  constexpr double kTakes_s = 120;
  const auto connection = session.connect();
  const auto now =
      connection.ask(&v1::CellService::Stub::GetStatus, v1::GetStatusRequest{}).cell_time();
  v1::AnalyseStabilityRequest request;
  request.set_channel(a.channel);
  *request.mutable_to_time() = now;
  request.mutable_to_time()->set_seconds(now.seconds() - std::llround(3600 * a.ago_h));
  *request.mutable_from_time() = request.to_time();
  request.mutable_from_time()->set_seconds(request.to_time().seconds() -
                                           std::llround(3600 * a.hours));
  return connection.ask(&v1::LookBackService::Stub::AnalyseStability, request, kTakes_s);
}

void print_head(const Console& console, const v1::AnalyseStabilityResponse& found) {
  console.out << found.channel() << ": " << found.sample_count() << " values every "
              << significant(found.interval_s(), 3) << " s, " << clock_text(found.from_time())
              << " to " << clock_text(found.to_time()) << " UTC";
  if (found.all_count() > found.sample_count())
    console.out << " (the longest stretch without a gap, of " << found.all_count() << ")";
  console.out << '\n';
}

ExitCode allan(const Session& session, const ChannelArguments& a) {
  const auto found = ask(session, a);
  if (session.console.json) {
    auto json = json_from(found);
    json.erase("spectrum");
    session.console.print_json(json);
    return ExitCode::done;
  }
  print_head(session.console, found);
  Table table({{"averaged over, s", Align::right},
               {"Allan deviation, " + found.unit(), Align::right},
               {"68 % interval", Align::right},
               {"", Align::right}});
  for (const auto& point : found.allan())
    table.add({significant(point.tau_s(), 4), significant(point.deviation(), 4),
               significant(point.low(), 3), significant(point.high(), 3)});
  table.print(session.console.out, session.console.paint_out());
  session.console.out << found.sentence() << '\n';
  return ExitCode::done;
}

ExitCode spectrum(const Session& session, const ChannelArguments& a) {
  const auto found = ask(session, a);
  if (session.console.json) {
    auto json = json_from(found);
    json.erase("allan");
    session.console.print_json(json);
    return ExitCode::done;
  }
  print_head(session.console, found);
  Table table(
      {{"frequency, Hz", Align::right}, {"density, " + found.unit() + "^2/Hz", Align::right}});
  for (const auto& point : found.spectrum())
    table.add({significant(point.frequency_hz(), 4), significant(point.density(), 4)});
  table.print(session.console.out, session.console.paint_out());
  return ExitCode::done;
}

}  // namespace

void add_channel_commands(CLI::App& app, Session& session) {
  CLI::App& channel =
      *app.add_subcommand("channel", "One channel over time")->require_subcommand(1);
  auto a = std::make_shared<ChannelArguments>();
  const auto add_options = [a](CLI::App& command) {
    command.add_option("CHANNEL", a->channel, "as recorded: x_mm, t07_degC")->required();
    command.add_option("--hours", a->hours, "of the record, cell time")
        ->check(number_between(0.01, 1000))
        ->capture_default_str();
    command.add_option("--ago", a->ago_h, "hours before now at which they end")
        ->check(number_between(0, 100000));
  };
  add_options(add_command(channel, session, "allan",
                          "Allan deviation: what averaging gains, and from when drift takes over",
                          [&session, a] { return allan(session, *a); }));
  add_options(add_command(channel, session, "spectrum", "Power spectral density",
                          [&session, a] { return spectrum(session, *a); }));
}

}  // namespace driftwise::cli
