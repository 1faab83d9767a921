#include <memory>

#include "clients/cli/commands/look_back/look_back_commands.h"
#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/text.h"
#include "clients/cli/core/validators.h"
#include "driftwise/v1/look_back_service.grpc.pb.h"
#include "server/core/cell_time.h"

namespace driftwise::cli {
namespace {

using LookBackStub = v1::LookBackService::Stub;

struct TimeNoteArguments {
  std::string text, at, channel, request_id;
  int limit = 100;
};

std::string line_of(const v1::TimeNote& note) {
  return clock_text(note.note_time()) + " UTC" +
         (note.channel().empty() ? "" : ", " + note.channel()) + ": " + note.text() + "  (" +
         note.who() + ", written " + utc_text(note.create_time()) + ")";
}

ExitCode pin(const Session& session, const TimeNoteArguments& a) {
  v1::AddTimeNoteRequest request;
  request.set_text(a.text);
  request.set_channel(a.channel);
  request.set_request_id(a.request_id);
  if (!a.at.empty()) {
    const auto time = parse_iso8601(a.at);
    if (!time)
      throw Failure{ExitCode::usage, "usage", "BAD_TIME",
                    "--at: found '" + a.at + "', expected UTC such as 2026-11-22T18:00:00Z"};
    constexpr std::int64_t kSecond_ns = 1'000'000'000;
    request.mutable_note_time()->set_seconds(time->utc_ns / kSecond_ns);
    request.mutable_note_time()->set_nanos(static_cast<std::int32_t>(time->utc_ns % kSecond_ns));
  }
  const auto note = session.connect().ask(&LookBackStub::AddTimeNote, request).note();
  if (session.console.json)
    session.console.print_json(json_from(note));
  else
    session.console.out << line_of(note) << '\n';
  return ExitCode::done;
}

ExitCode pinned(const Session& session, const TimeNoteArguments& a) {
  v1::ListTimeNotesRequest request;
  request.set_limit(a.limit);
  const auto response = session.connect().ask(&LookBackStub::ListTimeNotes, request);
  if (session.console.json) {
    session.console.print_json(json_from(response));
    return ExitCode::done;
  }
  for (const auto& note : response.notes()) session.console.out << line_of(note) << '\n';
  if (response.notes().empty()) session.console.out << "no notes are pinned to a time\n";
  return ExitCode::done;
}

}  // namespace

void add_time_note_commands(CLI::App& note, Session& session) {
  auto a = std::make_shared<TimeNoteArguments>();
  CLI::App& pinning = add_command(note, session, "pin",
                                  "Pins a remark to an instant: shown in plots over that time",
                                  [&session, a] { return pin(session, *a); });
  pinning.add_option("TEXT", a->text, "what happened")->required();
  pinning.add_option("--at", a->at, "UTC: 2026-11-22T18:00:00Z; else now");
  pinning.add_option("--channel", a->channel, "on this channel; else on the cell");
  pinning.add_option("--request-id", a->request_id, "the same again: the first note");
  CLI::App& listing = add_command(note, session, "pinned", "Remarks at a time, newest first",
                                  [&session, a] { return pinned(session, *a); });
  listing.add_option("--limit", a->limit, "at most so many")->check(number_between(1, 1000));
}

}  // namespace driftwise::cli
