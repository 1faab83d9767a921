#include "clients/cli/commands/cell/alarm_commands.h"

#include <memory>

#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "clients/cli/core/validators.h"
#include "driftwise/v1/watch_service.grpc.pb.h"

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

std::string standing_of(const v1::Alarm& alarm) {
  const std::string seen =
      alarm.has_acknowledge_time() ? "seen by " + alarm.acknowledged_by() : "not acknowledged";
  return (alarm.has_cleared_time() ? "over since " + clock_text(alarm.cleared_time()).substr(11)
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
    session.console.out << alarm.id() << "  " << level_word(paint, alarm.level()) << "  "
                        << clock_text(alarm.since_time()) << "  " << alarm.kind() << "  "
                        << standing_of(alarm) << "\n    " << alarm.message() << '\n';
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
    session.console.out << "alarm " << id << " acknowledged; it " << standing_of(response.alarm())
                        << '\n';
  return ExitCode::done;
}

}  // namespace

void add_alarm_commands(CLI::App& app, Session& session) {
  auto all = std::make_shared<bool>(false);
  auto id = std::make_shared<std::int64_t>(0);  // 0: not acknowledging
  const auto act = [&session, all, id] {
    return *id > 0 ? acknowledge_alarm(session, *id) : list_alarms(session, *all);
  };
  CLI::App& alarms =
      add_command(app, session, "alarms", "What asks for a person, newest first", act);
  alarms.add_flag("--all", *all, "also those that are over and acknowledged");
  // CLI11 calls the parent's action last: both are the same one.
  CLI::App& acknowledge =
      add_command(alarms, session, "acknowledge", "Says that you have seen one alarm", act);
  acknowledge.add_option("ALARM", *id, "its number")->required()->check(positive_number());
}

}  // namespace driftwise::cli
