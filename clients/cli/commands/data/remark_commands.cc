#include "clients/cli/commands/data/remark_commands.h"

#include <memory>

#include "clients/cli/commands/look_back/look_back_commands.h"
#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "clients/cli/core/validators.h"
#include "driftwise/v1/data_service.grpc.pb.h"
#include "server/formats/text/row_ranges.h"

namespace driftwise::cli {
namespace {

using RemarkStub = v1::DataService::Stub;
using Ranges = google::protobuf::RepeatedPtrField<v1::RowRange>;

struct ExclusionArguments {
  std::int64_t run = 0;
  std::string rows, reason;
};

struct NoteArguments {
  std::int64_t run = 0, model = 0, row = 0;
  std::string text;
};

void put_rows(const std::string& text, Ranges& out) {
  const auto rows = formats::parse_row_ranges(text);
  if (!rows)
    throw Failure{ExitCode::bad_input, "invalid_argument", rows.error().reason,
                  rows.error().message};
  for (const std::int64_t row : *rows) {
    if (out.empty() || out.rbegin()->last_row() + 1 != row) out.Add()->set_first_row(row);
    out.rbegin()->set_last_row(row);
  }
}

std::string rows_text(const Ranges& ranges) {
  std::string text;
  for (const auto& range : ranges) {
    text += (text.empty() ? "" : ",") + std::to_string(range.first_row());
    if (range.last_row() > range.first_row()) text += "-" + std::to_string(range.last_row());
  }
  return text;
}

ExitCode print_state(const Session& session, const v1::ExclusionState& state) {
  const Console& console = session.console;
  if (console.json) {
    console.print_json(json_from(state));
    return ExitCode::done;
  }
  console.out << "run " << state.run_id() << ": ";
  if (state.excluded_row_count() == 0)
    console.out << "no row is kept out of fits\n";
  else
    console.out << state.excluded_row_count()
                << " rows kept out of fits: " << rows_text(state.excluded_rows()) << "  (state "
                << state.exclusions_hash() << ")\n";
  if (!state.suspect_rows().empty())
    console.out << "suspect, by the daemon: " << rows_text(state.suspect_rows())
                << "  (put them back with 'driftwise data restore')\n";
  if (state.history().empty()) return ExitCode::done;
  Table table({{"when (UTC)"}, {"who"}, {"what"}, {"rows"}, {"reason"}});
  for (const auto& step : state.history())
    table.add({clock_text(step.exclude_time()), step.excluded_by(),
               step.suspect()    ? "suspect"
               : step.excluded() ? "out"
                                 : "back",
               rows_text(step.rows()), step.reason()});
  table.print(console.out, console.paint_out());
  return ExitCode::done;
}

template <class Request, class Method>
ExitCode change_rows(const Session& session, Method method, const ExclusionArguments& a) {
  Request request;
  request.set_run_id(a.run);
  put_rows(a.rows, *request.mutable_rows());
  request.set_reason(a.reason);
  return print_state(session, session.connect().ask(method, request).state());
}

ExitCode list_exclusions(const Session& session, std::int64_t run) {
  v1::ListExclusionsRequest request;
  request.set_run_id(run);
  return print_state(session, session.connect().ask(&RemarkStub::ListExclusions, request).state());
}

v1::NoteSubject subject_of(const NoteArguments& a) {
  v1::NoteSubject on;
  if (a.run > 0) on.set_run_id(a.run);
  if (a.row > 0) on.set_row(a.row);
  if (a.model > 0) on.set_model_id(a.model);
  return on;
}

std::string subject_text(const v1::NoteSubject& on) {
  if (on.has_model_id()) return "model " + std::to_string(on.model_id());
  return "run " + std::to_string(on.run_id()) +
         (on.has_row() ? ", row " + std::to_string(on.row()) : "");
}

ExitCode add_note(const Session& session, const NoteArguments& a) {
  v1::CreateNoteRequest request;
  *request.mutable_on() = subject_of(a);
  request.set_text(a.text);
  const auto note = session.connect().ask(&RemarkStub::CreateNote, request).note();
  if (session.console.json)
    session.console.print_json(json_from(note));
  else
    session.console.out << "noted on " << subject_text(note.on()) << ": " << note.text() << '\n';
  return ExitCode::done;
}

ExitCode list_notes(const Session& session, const NoteArguments& a) {
  v1::ListNotesRequest request;
  *request.mutable_on() = subject_of(a);
  const auto notes = session.connect().ask(&RemarkStub::ListNotes, request);
  if (session.console.json)
    session.console.print_json(json_from(notes));
  else if (notes.notes().empty())
    session.console.out << "no notes\n";
  else
    print_notes(session.console, notes);
  return ExitCode::done;
}

void add_subject(CLI::App& command, NoteArguments& a) {
  auto* run = command.add_option("--run", a.run, "on this run")->check(positive_number());
  command.add_option("--row", a.row, "on the point in this row of it, as `run points` counts")
      ->check(positive_number())
      ->needs(run);
  command.add_option("--model", a.model, "on this model")->check(positive_number())->excludes(run);
}

}  // namespace

void add_exclusion_commands(CLI::App& data, Session& session) {
  auto a = std::make_shared<ExclusionArguments>();
  const auto add_change = [a](CLI::App& command) {
    command.add_option("RUN", a->run, "number of the run")->required()->check(positive_number());
    command.add_option("--rows", a->rows, "such as 12,40-45, as `run points` counts them")
        ->required();
    command.add_option("--reason", a->reason, "why: it stands in the record")->required();
  };
  add_change(add_command(
      data, session, "exclude", "Keeps rows of a run out of fits, for a reason", [&session, a] {
        return change_rows<v1::ExcludeRowsRequest>(session, &RemarkStub::ExcludeRows, *a);
      }));
  add_change(add_command(data, session, "restore", "Puts rows back into fits", [&session, a] {
    return change_rows<v1::RestoreRowsRequest>(session, &RemarkStub::RestoreRows, *a);
  }));
  CLI::App& list = add_command(data, session, "exclusions",
                               "Which rows are out, and who took them out or put them back",
                               [&session, a] { return list_exclusions(session, a->run); });
  list.add_option("RUN", a->run, "number of the run")->required()->check(positive_number());
}

void add_note_commands(CLI::App& app, Session& session) {
  CLI::App& note = *app.add_subcommand("note", "Remarks on runs, points and models, kept for ever")
                        ->require_subcommand(1);
  auto a = std::make_shared<NoteArguments>();
  CLI::App& add = add_command(note, session, "add", "Adds a remark",
                              [&session, a] { return add_note(session, *a); });
  add.add_option("TEXT", a->text, "what to remember")->required();
  add_subject(add, *a);
  add_subject(add_command(note, session, "list", "Remarks, oldest first",
                          [&session, a] { return list_notes(session, *a); }),
              *a);
  add_time_note_commands(note, session);
}

v1::ListNotesResponse notes_of_run(const Connection& connection, std::int64_t run_id) {
  v1::ListNotesRequest request;
  request.mutable_on()->set_run_id(run_id);
  return connection.ask(&RemarkStub::ListNotes, request);
}

v1::ListNotesResponse notes_of_model(const Connection& connection, std::int64_t model_id) {
  v1::ListNotesRequest request;
  request.mutable_on()->set_model_id(model_id);
  return connection.ask(&RemarkStub::ListNotes, request);
}

void print_notes(const Console& console, const v1::ListNotesResponse& notes) {
  for (const auto& note : notes.notes())
    console.out << "note " << clock_text(note.create_time()) << " UTC, " << note.created_by()
                << ", " << subject_text(note.on()) << ": " << note.text() << '\n';
}

}  // namespace driftwise::cli
