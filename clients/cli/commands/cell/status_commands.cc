#include <memory>

#include "clients/cli/commands/cell/cell_commands.h"
#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "clients/cli/core/validators.h"
#include "clients/cli/pages/progress_bar.h"
#include "clients/cli/pages/run_text.h"
#include "clients/cli/pages/serving_text.h"
#include "driftwise/v1/cell_service.grpc.pb.h"
#include "driftwise/v1/plan_service.grpc.pb.h"

namespace driftwise::cli {
namespace {

using CellStub = v1::CellService::Stub;
using PlanStub = v1::PlanService::Stub;

std::string link_text(const Paint& paint, v1::Device::Link link) {
  switch (link) {
    case v1::Device::LINK_CONNECTED:
      return "connected";
    case v1::Device::LINK_CONNECTING:
      return paint.warn("connecting");
    case v1::Device::LINK_FAILED:
      return paint.bad("failed");
    default:
      return paint.warn("disconnected");
  }
}

std::string database_text(const v1::DatabaseStatus& database) {
  if (!database.troubles().empty()) return "damaged: see below";
  std::string text = database.has_clean_time()
                         ? "found clean on " + clock_text(database.clean_time()) + " UTC"
                         : "not checked whole yet";
  if (database.checked_table_count() < database.table_count())
    text += ", a check is under way: " + std::to_string(database.checked_table_count()) + " of " +
            std::to_string(database.table_count()) + " tables";
  return text;
}

// A run needs no lease once it has begun, and nobody else gets one that moves anything meanwhile.
std::string lease_without_holder(const v1::GetStatusResponse& status) {
  if (!status.has_run() || is_over(status.run().run().state())) return "free";
  return "nobody holds it; run " + std::to_string(status.run().run().id()) +
         " moves the robot until it ends";
}

void print_status(const Console& console, const v1::GetStatusResponse& status,
                  const v1::ListPlansResponse& plans) {
  const Paint paint = console.paint_out();
  console.out << paint.bold(status.cell_name()) << "  driftwised " << status.version() << "  "
              << clock_text(status.cell_time()) << " UTC";
  if (status.speed() != 1.0)
    console.out << ", cell time at " << significant(status.speed(), 4) << "x";
  console.out << '\n';
  console.out << "serving  " << serving_text(status, plans) << '\n';
  console.out << "lease    "
              << (status.has_lease()
                      ? status.lease().holder() + " (" + status.lease().peer() + ") until " +
                            utc_text(status.lease().end_time()).substr(11)
                      : lease_without_holder(status))
              << '\n';
  console.out << "run      "
              << (status.has_run() ? progress_line(status.run(), std::nan(""), 200)
                                   : "none under way")
              << '\n';
  console.out << "record   " << database_text(status.database()) << '\n';
  if (!status.web_address().empty()) console.out << "web      " << status.web_address() << '\n';
  for (const auto& device : status.devices())
    if (device.link() != v1::Device::LINK_CONNECTED)
      console.out << "device   " << device.id() << " " << link_text(paint, device.link()) << " "
                  << device.last_error() << '\n';
  for (const auto& sentence : status.attention())
    console.out << paint.warn("look     ") << sentence << '\n';
  if (status.values_size() == 0) return;
  console.out << '\n';
  Table table({{"channel"}, {"value", Align::right}, {"age", Align::right}, {"device"}, {""}});
  for (const auto& value : status.values()) {
    const int decimals = value.channel().ends_with("_mm")   ? 6
                         : value.channel().ends_with("_nm") ? 1
                                                            : 4;
    table.add({value.channel(),
               value.has_value() ? fixed(value.value(), decimals) : "-",
               value.has_age_duration() ? span_text(seconds_of(value.age_duration())) : "never",
               value.device_id(),
               {value.stale() ? "stale" : "", Colour::warn}});
  }
  table.print(console.out, paint);
}

void print_devices(const Console& console, const v1::ListDevicesResponse& response) {
  const Paint paint = console.paint_out();
  Table table({{"device"},
               {"kind"},
               {"address"},
               {"exchanges", Align::right},
               {"errors", Align::right},
               {"latency", Align::right},
               {"link"},
               {"identity"}});
  for (const auto& device : response.devices())
    table.add(
        {device.id(), device.kind(), device.address(), std::to_string(device.exchange_count()),
         std::to_string(device.error_count()),
         device.exchange_count() > 0 ? span_text(seconds_of(device.last_latency_duration())) : "-",
         link_text(Paint(false), device.link()), device.identity()});
  table.print(console.out, paint);
  for (const auto& device : response.devices()) {
    for (const auto& axis : device.axes())
      console.out << device.id() << ": " << axis.channel() << " is axis " << axis.device_axis()
                  << ", soft limits " << fixed(axis.min_mm(), 4) << " to "
                  << fixed(axis.max_mm(), 4) << " mm\n";
    if (!device.last_error().empty())
      console.out << paint.warn(device.id() + ": ") << device.last_error() << '\n';
  }
}

std::string event_line(const v1::Event& event) {
  std::string line =
      std::to_string(event.id()) + "  " + utc_text(event.event_time()) + "  " + event.what();
  if (event.has_run_id()) line += "  run " + std::to_string(event.run_id());
  line += "  " + event.who();
  if (!event.detail().empty()) line += ": " + event.detail();
  return line;
}

void print_event(const Console& console, const v1::Event& event) {
  if (console.json)
    console.out << json_from(event).dump() << '\n';
  else
    console.out << event_line(event) << '\n';
  console.out << std::flush;
}

// With --timeout a command that follows ends when the time is up: no error once it has heard
// something.
template <class Follow>
ExitCode follow_for_the_time(const Session& session, Follow follow) {
  bool heard = false;
  try {
    follow(heard);
  } catch (const Failure& failure) {
    if (failure.reason != "TIMEOUT" || !heard || session.timeout_s <= 0) throw;
  }
  return ExitCode::done;
}

ExitCode show_events(const Session& session, std::int64_t after, bool follow) {
  const auto connection = session.connect();
  if (follow) {
    v1::WatchEventsRequest request;
    request.set_after_event_id(after);
    return follow_for_the_time(session, [&](bool& heard) {
      connection.follow(&CellStub::WatchEvents, request,
                        [&](const v1::WatchEventsResponse& response) {
                          heard = true;
                          print_event(session.console, response.event());
                          return true;
                        });
    });
  }
  v1::ListEventsRequest request;
  request.set_after_event_id(after);
  request.set_limit(1000);
  while (true) {
    const auto page = connection.ask(&CellStub::ListEvents, request);
    for (const auto& event : page.events()) print_event(session.console, event);
    if (page.events_size() < 1000) return ExitCode::done;
    request.set_after_event_id(page.events(page.events_size() - 1).id());
  }
}

void print_reading(const Console& console, const v1::WatchReadingsResponse& response) {
  if (console.json) {
    console.out << json_from(response).dump() << '\n' << std::flush;
    return;
  }
  if (response.missed_count() > 0)
    console.err << response.missed_count() << " readings missed here; the record has them\n";
  console.out << utc_text(response.reading().end_time()) << "  " << response.reading().device_id();
  for (const auto& value : response.reading().values())
    console.out << "  " << value.channel() << "="
                << (value.has_value() ? significant(value.value(), 10) : "-");
  console.out << '\n' << std::flush;
}

ExitCode follow_readings(const Session& session, const std::string& device) {
  v1::WatchReadingsRequest request;
  request.set_device_id(device);
  return follow_for_the_time(session, [&](bool& heard) {
    session.connect().follow(&CellStub::WatchReadings, request,
                             [&](const v1::WatchReadingsResponse& response) {
                               heard = true;
                               print_reading(session.console, response);
                               return true;
                             });
  });
}

}  // namespace

void add_status_commands(CLI::App& app, Session& session) {
  add_command(app, session, "status", "The cell now: run, lease, model, latest values", [&session] {
    const auto daemon = session.connect();
    const auto status = daemon.ask(&CellStub::GetStatus, v1::GetStatusRequest{});
    if (session.console.json)
      session.console.print_json(json_from(status));
    else
      print_status(session.console, status,
                   daemon.ask(&PlanStub::ListPlans, v1::ListPlansRequest{}));
    return ExitCode::done;
  });
  add_command(app, session, "devices", "Controllers and instruments, with their links", [&session] {
    const auto devices = session.connect().ask(&CellStub::ListDevices, v1::ListDevicesRequest{});
    if (session.console.json)
      session.console.print_json(json_from(devices));
    else
      print_devices(session.console, devices);
    return ExitCode::done;
  });
  struct EventArguments {
    std::int64_t after = 0;
    bool follow = false;
  };
  auto a = std::make_shared<EventArguments>();
  CLI::App& events =
      add_command(app, session, "events", "What happened, and who did it; one line each",
                  [&session, a] { return show_events(session, a->after, a->follow); });
  events.add_option("--after", a->after, "events after this number only")
      ->check(number_from_zero());
  events.add_flag("--follow", a->follow, "go on with what happens next");
  auto device = std::make_shared<std::string>();
  CLI::App& readings =
      add_command(app, session, "readings", "Follows the instruments' readings as they come",
                  [&session, device] { return follow_readings(session, *device); });
  readings.add_option("DEVICE", *device, "of this device only");
}

}  // namespace driftwise::cli
