#include <chrono>
#include <cmath>
#include <map>
#include <memory>
#include <thread>

#include "clients/cli/commands/commissioning/commissioning_commands.h"
#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "clients/cli/core/validators.h"
#include "driftwise/v1/cell_service.grpc.pb.h"
#include "driftwise/v1/commissioning_service.grpc.pb.h"
#include "server/core/channel.h"

namespace driftwise::cli {
namespace {

using CellStub = v1::CellService::Stub;
using CommissioningStub = v1::CommissioningService::Stub;
constexpr double kMathematics_s = 120;

struct AlignArguments {
  bool once = false, begin = false, end = false;
  double every_s = 0.5, minutes = 60, nm_per_h = 20, k_per_h = 0.05, window_min = 30;
  std::vector<std::string> channels;
};

// Light, lengths and spots, for a person who turns a screw.
bool is_shown(const v1::LatestValue& value) {
  const auto& name = value.channel();
  return is_light_level(name) || name.ends_with("_arcsec") ||
         (name.ends_with("_mm") && !without_robot(name).starts_with("q"));
}

ExitCode align(const Session& session, const AlignArguments& a) {
  const auto connection = session.connect();
  std::map<std::string, double> most;
  const Paint paint = session.console.paint_out();
  while (true) {
    const auto status = connection.ask(&CellStub::GetStatus, v1::GetStatusRequest{});
    Table table({{"instrument"},
                 {"channel"},
                 {"now", Align::right},
                 {"most seen", Align::right},
                 {"age", Align::right}});
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    for (const auto& value : status.values()) {
      if (!is_shown(value)) continue;
      const auto& channel = value.channel();
      if (value.has_value()) {
        const double size = channel.ends_with("_pct") ? value.value() : std::abs(value.value());
        const auto known = most.emplace(channel, size).first;
        known->second = std::max(known->second, size);
      }
      const int digits = channel.ends_with("_mm") ? 6 : 2;
      const std::string unit = " " + channel.substr(channel.rfind('_') + 1);
      const bool seen = most.contains(channel);
      table.add({value.device_id(), channel,
                 value.has_value() ? fixed(value.value(), digits) + unit : "none",
                 seen ? fixed(most[channel], digits) + unit : "none",
                 fixed(seconds_of(value.age_duration()), 1) + " s"});
      rows.push_back(
          {{"device_id", value.device_id()},
           {"channel", channel},
           {"value", value.has_value() ? nlohmann::ordered_json(value.value()) : nullptr},
           {"most", seen ? nlohmann::ordered_json(most[channel]) : nullptr},
           {"age_s", seconds_of(value.age_duration())}});
    }
    if (session.console.json)
      session.console.print_json({{"values", rows}});
    else {
      if (session.console.out_is_terminal && !a.once) session.console.out << "\x1b[H\x1b[J";
      table.print(session.console.out, paint);
      session.console.out << std::flush;
    }
    if (a.once || !connection.is_heard()) return ExitCode::done;
    std::this_thread::sleep_for(std::chrono::duration<double>(a.every_s));
    if (connection.interrupted()) return ExitCode::interrupted;
  }
}

ExitCode thermometers(const Session& session, const AlignArguments& a) {
  const auto connection = session.connect();
  const auto now = connection.ask(&CellStub::GetStatus, v1::GetStatusRequest{}).cell_time();
  v1::CompareThermometersRequest request;
  *request.mutable_to_time() = now;
  *request.mutable_from_time() = now;
  request.mutable_from_time()->set_seconds(now.seconds() - std::llround(60 * a.minutes));
  for (const auto& channel : a.channels)
    request.add_channels(channel.find('_') == std::string::npos ? channel + "_degC" : channel);
  const auto response =
      connection.ask(&CommissioningStub::CompareThermometers, request, kMathematics_s);
  bool any_out = false;
  for (const auto& one : response.thermometers()) any_out = any_out || one.out();
  if (session.console.json) {
    session.console.print_json(json_from(response));
    return any_out ? ExitCode::negative : ExitCode::done;
  }
  const Paint paint = session.console.paint_out();
  Table table({{"thermometer"},
               {"part"},
               {"offset, mK", Align::right},
               {"u", Align::right},
               {"u certificate", Align::right},
               {"drift, mK/h", Align::right},
               {"noise, mK", Align::right},
               {""}});
  for (const auto& one : response.thermometers())
    table.add({one.channel(),
               one.part(),
               signed_fixed(1e3 * one.offset_k(), 1),
               fixed(1e3 * one.u_offset_k(), 1),
               fixed(1e3 * one.u_certificate_k(), 1),
               signed_fixed(1e3 * one.drift_k_per_h(), 1),
               fixed(1e3 * one.noise_k(), 1),
               {one.out() ? "out" : "in", one.out() ? Colour::bad : Colour::none}});
  table.print(session.console.out, paint);
  session.console.out << "mean " << fixed(response.mean_degc(), 3) << " degC, "
                      << signed_fixed(1e3 * response.common_drift_k_per_h(), 1) << " mK/h in "
                      << clock_text(response.from_time()) << " to "
                      << clock_text(response.to_time()) << " UTC"
                      << (response.quiet() ? ", quiet\n"
                                           : ": not quiet, offsets may be differences of the "
                                             "places\n");
  for (const auto& one : response.thermometers())
    if (one.out()) session.console.out << one.sentence() << '\n';
  return any_out ? ExitCode::negative : ExitCode::done;
}

ExitCode show_rest(const Session& session, const v1::Rest& rest) {
  if (session.console.json) {
    session.console.print_json(json_from(rest));
    return ExitCode::done;
  }
  const Paint paint = session.console.paint_out();
  Table table({{"channel"},
               {"rate", Align::right},
               {"u", Align::right},
               {"limit", Align::right},
               {""},
               {"change", Align::right},
               {"warm since"}});
  for (const auto& one : rest.channels()) {
    const int digits = one.change_unit() == "nm" ? 1 : 4;
    table.add({one.channel(), one.has_rate() ? signed_fixed(one.rate(), digits) : "-",
               one.has_u_rate() ? fixed(one.u_rate(), digits) : "-", significant(one.limit(), 3),
               one.unit(), signed_fixed(one.change(), digits) + " " + one.change_unit(),
               one.has_warm_time() ? clock_text(one.warm_time()) + " UTC" : "not yet"});
  }
  table.print(session.console.out, paint);
  session.console.out << (rest.has_warm_time() ? paint.good(rest.sentence()) : rest.sentence())
                      << "  (rest since " << clock_text(rest.begin_time()) << " UTC"
                      << (rest.has_end_time() ? ", over: " + rest.end_reason() : std::string())
                      << ")\n";
  return ExitCode::done;
}

ExitCode rest(const Session& session, const AlignArguments& a) {
  const auto connection = session.connect();
  if (a.begin) {
    v1::BeginRestRequest request;
    request.set_length_limit_nm_per_h(a.nm_per_h);
    request.set_temperature_limit_k_per_h(a.k_per_h);
    request.mutable_window_duration()->set_seconds(std::llround(60 * a.window_min));
    return show_rest(session,
                     connection.ask(&CommissioningStub::BeginRest, request, kMathematics_s).rest());
  }
  if (a.end)
    return show_rest(
        session,
        connection.ask(&CommissioningStub::EndRest, v1::EndRestRequest{}, kMathematics_s).rest());
  return show_rest(
      session,
      connection.ask(&CommissioningStub::GetRest, v1::GetRestRequest{}, kMathematics_s).rest());
}

}  // namespace

void add_align_commands(CLI::App& app, Session& session) {
  auto a = std::make_shared<AlignArguments>();
  auto chosen = std::make_shared<std::string>();
  // CLI11 calls the parent's action last: all are the same one.
  const auto act = [&session, a, chosen] {
    return *chosen == "thermometers" ? thermometers(session, *a)
           : *chosen == "rest"       ? rest(session, *a)
                                     : align(session, *a);
  };
  const auto choose = [&session, chosen, act](const char* name) {
    return [&session, chosen, act, name] {
      *chosen = name;
      session.action = act;
    };
  };
  CLI::App& live = add_command(app, session, "align",
                               "Light level, lengths and spots live, with the most seen", act);
  live.add_flag("--once", a->once, "one picture");
  live.add_option("--every", a->every_s, "seconds between two pictures")
      ->check(number_between(0.1, 3600));
  CLI::App& compare = add_command(live, session, "thermometers",
                                  "Thermometers at one temperature: each one's offset", act);
  compare.callback(choose("thermometers"));
  compare.add_option("--minutes", a->minutes, "of the record, up to now (cell time)")
      ->check(number_between(8, 10080))
      ->capture_default_str();
  compare.add_option("--channels", a->channels, "t01,t02; else all probes")->delimiter(',');
  CLI::App& resting =
      add_command(live, session, "rest",
                  "A cell at rest: drift of lengths and temperatures, warm since when", act);
  resting.callback(choose("rest"));
  auto* begin = resting.add_flag("--begin", a->begin, "record lengths from now on");
  resting.add_flag("--end", a->end, "end it")->excludes(begin);
  resting.add_option("--nm-per-h", a->nm_per_h, "limit of the lengths")
      ->check(number_between(1e-3, 1e9))
      ->capture_default_str();
  resting.add_option("--K-per-h", a->k_per_h, "limit of the temperatures")
      ->check(number_between(1e-6, 1e6))
      ->capture_default_str();
  resting.add_option("--window", a->window_min, "minutes over which a rate is taken")
      ->check(number_between(5, 360))
      ->capture_default_str();
}

}  // namespace driftwise::cli
