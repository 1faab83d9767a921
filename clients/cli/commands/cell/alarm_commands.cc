#include "clients/cli/commands/cell/alarm_commands.h"

#include <charconv>
#include <cmath>
#include <memory>
#include <optional>

#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "clients/cli/core/validators.h"
#include "driftwise/v1/watch_service.grpc.pb.h"
#include "server/core/text/with_subject.h"

namespace driftwise::cli {
namespace {

using WatchStub = v1::WatchService::Stub;

std::string level_word(const Paint& paint, v1::Alarm::Level level) {
  switch (level) {
    case v1::Alarm::LEVEL_NOTICE:
      return "notice";
    case v1::Alarm::LEVEL_WARNING:
      return paint.warn("warning");
    default:
      return paint.bad("failed");
  }
}

std::string priority_word(v1::Alarm::Priority priority) {
  switch (priority) {
    case v1::Alarm::PRIORITY_LOW:
      return "low";
    case v1::Alarm::PRIORITY_HIGH:
      return "high";
    case v1::Alarm::PRIORITY_CRITICAL:
      return "critical";
    default:
      return "medium";
  }
}

std::string standing_of(const v1::Alarm& alarm) {
  if (alarm.has_shelved_until_time())
    return "shelved by " + alarm.shelved_by() + " until " + utc_text(alarm.shelved_until_time()) +
           ": " + alarm.shelve_reason();
  const std::string seen =
      alarm.has_acknowledge_time() ? "seen by " + alarm.acknowledged_by() : "not acknowledged";
  return (alarm.has_cleared_time() ? "over since " + utc_text(alarm.cleared_time()).substr(11)
                                   : "holds") +
         ", " + seen;
}

ExitCode list_alarms(const Session& session, bool all) {
  v1::ListAlarmsRequest request;
  request.set_with_history(all);
  const auto response = session.connect().ask(&WatchStub::ListAlarms, request);
  if (session.console.json) {
    session.console.print_json(json_from(response));
    return ExitCode::done;
  }
  const Paint paint = session.console.paint_out();
  for (const auto& alarm : response.alarms()) {
    session.console.out << (alarm.id() == 0 ? "-" : std::to_string(alarm.id())) << "  "
                        << level_word(paint, alarm.level()) << "  "
                        << priority_word(alarm.priority()) << "  " << utc_text(alarm.since_time())
                        << "  " << alarm.kind() << "  " << standing_of(alarm) << "\n    "
                        << with_subject(alarm.subject(), alarm.message()) << '\n';
    for (const auto& one : alarm.consequences())
      session.console.out << "      hence: " << one << '\n';
  }
  if (response.alarms().empty()) session.console.out << "nothing asks for a person\n";
  return ExitCode::done;
}

ExitCode acknowledge_alarm(const Session& session, std::int64_t id) {
  v1::AcknowledgeAlarmRequest request;
  request.set_alarm_id(id);
  const auto response = session.connect().ask(&WatchStub::AcknowledgeAlarm, request);
  if (session.console.json)
    session.console.print_json(json_from(response.alarm()));
  else
    session.console.out << "alarm " << id << " acknowledged: " << standing_of(response.alarm())
                        << '\n';
  return ExitCode::done;
}

// "90s", "45m", "2h", "1d": seconds.
std::optional<double> seconds_of_span(const std::string& text) {
  double value = 0;
  const char* const last = text.data() + text.size();
  const auto [end, code] = std::from_chars(text.data(), last, value);
  if (code != std::errc{} || end + 1 != last || !(value > 0)) return std::nullopt;
  switch (*end) {
    case 's':
      return value;
    case 'm':
      return value * 60;
    case 'h':
      return value * 3600;
    case 'd':
      return value * 86'400;
    default:
      return std::nullopt;
  }
}

CLI::Validator time_span() {
  return CLI::Validator(
      [](const std::string& text) -> std::string {
        if (const auto found = seconds_of_span(text); found && *found <= 86'400) return {};
        return "found '" + text + "', expected a time such as 90s, 45m or 2h, at most 24h";
      },
      "TIME");
}

struct AlarmArguments {
  enum class Act { list, acknowledge, shelve, unshelve } act = Act::list;
  bool all = false;
  std::int64_t id = 0;
  std::string span, reason;
};

ExitCode print_shelved(const Session& session, const v1::Alarm& alarm) {
  if (session.console.json)
    session.console.print_json(json_from(alarm));
  else
    session.console.out << "alarm " << alarm.id() << ": " << standing_of(alarm) << '\n';
  return ExitCode::done;
}

ExitCode shelve_alarm(const Session& session, const AlarmArguments& a) {
  v1::ShelveAlarmRequest request;
  request.set_alarm_id(a.id);
  const double seconds = seconds_of_span(a.span).value_or(0);
  request.mutable_shelve_duration()->set_seconds(static_cast<std::int64_t>(seconds));
  request.mutable_shelve_duration()->set_nanos(
      static_cast<std::int32_t>((seconds - std::floor(seconds)) * 1e9));
  request.set_reason(a.reason);
  return print_shelved(session, session.connect().ask(&WatchStub::ShelveAlarm, request).alarm());
}

ExitCode unshelve_alarm(const Session& session, const AlarmArguments& a) {
  v1::UnshelveAlarmRequest request;
  request.set_alarm_id(a.id);
  return print_shelved(session, session.connect().ask(&WatchStub::UnshelveAlarm, request).alarm());
}

ExitCode list_receivers(const Session& session, int limit) {
  v1::ListReceiversRequest request;
  request.set_limit(limit);
  const auto response = session.connect().ask(&WatchStub::ListReceivers, request);
  if (session.console.json) {
    session.console.print_json(json_from(response));
    return ExitCode::done;
  }
  const Paint paint = session.console.paint_out();
  auto& out = session.console.out;
  if (response.receivers().empty())
    out << "nobody outside this machine is told: the cell file has no [[notify]]\n";
  for (const auto& one : response.receivers()) {
    out << one.name() << "  " << one.way() << "  "
        << (one.has_failing_time()   ? paint.bad("failing since " + utc_text(one.failing_time()))
            : one.has_deliver_time() ? "last message " + utc_text(one.deliver_time())
                                     : std::string("no message yet"));
    if (one.waiting_count() > 0) out << ", " << one.waiting_count() << " waiting";
    out << (one.answer().empty() ? "" : "\n    " + one.answer()) << '\n';
  }
  Table table({{"alarm", Align::right},
               {"receiver"},
               {"told (UTC)"},
               {"messages", Align::right},
               {"over told (UTC)"},
               {"failed", Align::right},
               {"error"}});
  for (const auto& one : response.tellings())
    table.add({std::to_string(one.alarm_id()), one.receiver(),
               one.has_firing_time() ? clock_text(one.firing_time()) : "",
               std::to_string(one.message_count()),
               one.has_resolved_time() ? clock_text(one.resolved_time()) : "",
               std::to_string(one.failed_count()), one.error()});
  if (!table.empty()) table.print(out, paint);
  return ExitCode::done;
}

ExitCode test_receiver(const Session& session, const std::string& name) {
  v1::TestReceiverRequest request;
  request.set_name(name);
  // A command has 30 s, behind a message that is under way.
  constexpr double kReceiverTakes_s = 75;
  const auto response = session.connect().ask(&WatchStub::TestReceiver, request, kReceiverTakes_s);
  if (session.console.json)
    session.console.print_json(json_from(response));
  else
    session.console.out << name << ": " << response.answer() << '\n';
  return ExitCode::done;
}

void add_notify_commands(CLI::App& app, Session& session) {
  CLI::App& notify = *app.add_subcommand("notify", "Receivers of alarms outside this machine");
  notify.require_subcommand(1);
  auto limit = std::make_shared<int>(0);
  CLI::App& list = add_command(notify, session, "list", "Receivers, and what each was told",
                               [&session, limit] { return list_receivers(session, *limit); });
  list.add_option("--limit", *limit, "so many alarms at most (100)")->check(positive_number());
  auto name = std::make_shared<std::string>();
  CLI::App& test =
      add_command(notify, session, "test", "Sends a test message and prints what came back",
                  [&session, name] { return test_receiver(session, *name); });
  test.add_option("NAME", *name, "of the receiver in the cell file")->required();
}

}  // namespace

void add_alarm_commands(CLI::App& app, Session& session) {
  using Act = AlarmArguments::Act;
  auto a = std::make_shared<AlarmArguments>();
  const auto act = [&session, a] {
    switch (a->act) {
      case Act::acknowledge:
        return acknowledge_alarm(session, a->id);
      case Act::shelve:
        return shelve_alarm(session, *a);
      case Act::unshelve:
        return unshelve_alarm(session, *a);
      case Act::list:
        break;
    }
    return list_alarms(session, a->all);
  };
  CLI::App& alarms =
      add_command(app, session, "alarms", "What asks for a person, newest first", act);
  alarms.add_flag("--all", a->all, "also those that are over and acknowledged");
  // CLI11 calls the parent's action last: all are the same one.
  const auto add = [&](const char* name, const char* what, Act which) -> CLI::App& {
    CLI::App& command = add_command(alarms, session, name, what, act);
    command.add_option("ALARM", a->id, "its number")
        ->required()
        ->check(number_that(
            [](double value) { return value > 0 && value - value == 0; },
            "a number above 0 (an alarm with - in its place is not on record yet: it can "
            "be answered once the record takes it)",
            "POSITIVE"));
    command.parse_complete_callback([a, which] { a->act = which; });
    return command;
  };
  add("acknowledge", "Says that you have seen one alarm", Act::acknowledge);
  CLI::App& shelve =
      add("shelve", "Sets one alarm aside for a time; it comes back by itself", Act::shelve);
  shelve.add_option("--for", a->span, "how long: 90s, 45m, 2h; at most 24h")
      ->required()
      ->check(time_span());
  shelve.add_option("--reason", a->reason, "why; stands in the record")->required();
  add("unshelve", "Brings a shelved alarm back now", Act::unshelve);
  add_notify_commands(app, session);
}

}  // namespace driftwise::cli
