#include "clients/cli/commands/indentation/indent_commands.h"

#include <algorithm>
#include <filesystem>
#include <memory>

#include "clients/cli/commands/indentation/indent_checks.h"
#include "clients/cli/commands/indentation/indent_page.h"
#include "clients/cli/commands/indentation/indent_report.h"
#include "clients/cli/commands/indentation/wire_cell.h"
#include "clients/cli/core/hold_question.h"
#include "clients/cli/core/text.h"
#include "clients/cli/core/value_or_throw.h"
#include "driftwise/v1/indentation_service.grpc.pb.h"
#include "server/core/reasons.h"
#include "server/core/text/shown_text.h"
#include "server/core/try.h"
#include "server/formats/indentation/indents_csv.h"
#include "server/formats/indentation/procedure_json.h"

namespace driftwise::cli {
namespace {

using indentation::ProcedureRecord;

struct IndentArguments {
  std::string file, table, output;
  double lever_mm = 100, hardness_hv = 170, wanted_um = 1;
  bool dry_run = false, fresh = false;
  HoldOptions hold;
};

std::string record_path(const std::string& file) { return file + ".state.json"; }

formats::IndentationFile file_of(const std::string& text, const IndentArguments& a) {
  return value_or_throw(formats::read_indentation_file(text, a.file));
}

formats::IndentationFile read_file(const IndentArguments& a) {
  return file_of(read_input_file(a.file), a);
}

// "12": an indentation of the daemon's record, not a file.
std::int64_t number_in(const std::string& text) {
  const bool is_number = !text.empty() && text.size() <= 18 &&
                         text.find_first_not_of("0123456789") == std::string::npos;
  return is_number ? std::stoll(text) : 0;
}

ProcedureRecord stored_record(const std::string& file) {
  const std::string path = record_path(file);
  return value_or_throw(formats::read_procedure_json(read_input_file(path), path));
}

// A record that cannot be kept is an error of the procedure, which retracts before it ends.
Result<void> kept_record(const std::string& file, const ProcedureRecord& record) {
  try {
    write_output_file(record_path(file), formats::procedure_json(record));
  } catch (const Failure& failure) {
    return fail(ErrorCode::failed_precondition, reasons::kCannotWrite,
                failure.message + ": make room there; the same command goes on");
  }
  return {};
}

void say_plan(const Console& console, const formats::IndentationFile& file,
              const ProcedureRecord& record) {
  console.out << file.name << ": tool " << file.rules.tool << ", "
              << (file.by_plan ? std::string("motor coordinates by the promoted plan")
                               : "raw motor coordinates by geometry: " + file.reason)
              << "\nnext: " << to_string(record.stage) << "; " << record.contacts
              << " contacts so far, " << record.indents.size() << " of "
              << file.rules.indents.size() << " indents made\n";
}

// Beyond the file nothing of a procedure's errors is the file's: the cell could not, or would not.
Failure failure_of_procedure(const Error& error) {
  const ExitCode exit = error.code == ErrorCode::unavailable        ? ExitCode::unreachable
                        : error.code == ErrorCode::invalid_argument ? ExitCode::bad_input
                                                                    : ExitCode::refused;
  return {exit, std::string(to_string(error.code)), error.reason, error.message};
}

ExitCode start(const Session& session, const IndentArguments& a) {
  const auto& console = session.console;
  const auto text = read_input_file(a.file);
  const auto file = file_of(text, a);
  ProcedureRecord record;
  if (std::filesystem::exists(record_path(a.file)) && !a.fresh) record = stored_record(a.file);
  const auto connection = session.connect();
  check_against_cell(connection, file);
  if (a.dry_run) {
    say_plan(console, file, record);
    return ExitCode::done;
  }
  WireCell cell(connection, file,
                answer_about_present_run(console, connection, a.hold, "Move the robots"));
  IndentReport report(connection, console, text, record);
  write_output_file(record_path(a.file), formats::procedure_json(record));
  console.err << "indentation " << report.id() << '\n';
  std::size_t said = record.log.size();
  ProcedureRecord kept = record;
  const auto done =
      carry_out(cell, file.rules, record, [&](const ProcedureRecord& now) -> Result<void> {
        for (; said < now.log.size(); ++said) console.err << now.log[said] << '\n' << std::flush;
        // First the file: were the daemon's record the younger one, the file could not go on.
        DRIFTWISE_RETURN_IF_ERROR(kept_record(a.file, now));
        kept = now;
        report.report(now);
        return {};
      });
  report.report(kept, done ? "all indents are made" : done.error().message);
  if (!done && done.error().code == ErrorCode::cancelled)
    throw Failure{ExitCode::interrupted, "cancelled", done.error().reason, done.error().message};
  if (!done) throw failure_of_procedure(done.error());
  if (console.json)
    console.print_json(nlohmann::ordered_json::parse(formats::procedure_json(record)));
  else
    console.out << "made " << record.indents.size() << " indents with " << record.contacts
                << " contacts; the first is contact " << record.zero.contact
                << ". Measure them in the microscope, then: driftwise indent import " << a.file
                << " microscope.csv\n";
  return ExitCode::done;
}

ExitCode show(const Session& session, const IndentArguments& a) {
  if (const auto id = number_in(a.file); id > 0) {
    print_stored_indentation(session, id, a.output);
    return ExitCode::done;
  }
  const auto file = read_file(a);
  const auto record = stored_record(a.file);
  if (session.console.json) {
    session.console.print_json(nlohmann::ordered_json::parse(formats::procedure_json(record)));
    return ExitCode::done;
  }
  say_plan(session.console, file, record);
  for (const auto& line : record.log) session.console.out << "  " << line << '\n';
  return ExitCode::done;
}

ExitCode print_table(const Session& session, const std::vector<indentation::Indent>& indents,
                     const indentation::ToolRules& tool, double wanted_um) {
  const auto rows = value_or_throw(indentation::indent_table(indents, tool));
  const auto report = value_or_throw(indentation::tip_report(rows, wanted_um));
  print_indents(session.console, rows, report, tool);
  return report.conformity == indentation::Conformity::within ? ExitCode::done : ExitCode::negative;
}

ExitCode table(const Session& session, const IndentArguments& a) {
  const auto indents = value_or_throw(formats::read_indents_csv(read_input_file(a.file), a.file));
  return print_table(session, indents, {.lever_mm = a.lever_mm, .hardness_hv = a.hardness_hv},
                     a.wanted_um);
}

// A refusal of what a file holds, with the file's name.
template <class T>
T in_file(const std::string& file, Result<T> result) {
  if (!result) result.error().message.insert(0, file + ": ");
  return value_or_throw(std::move(result));
}

// Contacts by what moved the robots there: "zero, A, B: plan 1, mn=4, ma=coarse:1".
void print_answers(const Console& console, const ProcedureRecord& record) {
  if (console.json) return;                             // `indent show --json` has them
  std::vector<std::pair<std::string, std::string>> by;  // what answered, indents
  for (const auto& made : record.indents) {
    const auto known = std::ranges::find(by, made.by, &std::pair<std::string, std::string>::first);
    if (known == by.end())
      by.emplace_back(made.by, made.planned.id);
    else
      known->second += ", " + made.planned.id;
  }
  console.out << "\nmoved to by\n";
  for (const auto& [what, indents] : by) console.out << "  " << indents << ": " << what << '\n';
}

// The table onto the daemon's record; without a daemon it is only printed.
void import_into_daemon(const Session& session, const std::string& key, const std::string& csv) {
  if (key.empty()) return;
  try {
    const auto connection = session.connect();
    v1::ImportIndentTableRequest request;
    request.set_indentation_id(indentation_of_key(connection, key));
    request.set_microscope_csv(csv);
    connection.ask(&v1::IndentationService::Stub::ImportIndentTable, request);
  } catch (const Failure& failure) {
    session.console.err << "the table is not on the daemon's record, and not on its page: "
                        << failure.message << '\n';
  }
}

ExitCode import(const Session& session, const IndentArguments& a) {
  const auto file = read_file(a);
  const auto record = stored_record(a.file);
  const auto csv = read_input_file(a.table);
  const auto rows = value_or_throw(formats::read_microscope_csv(csv, a.table));
  if (record.stage != indentation::Stage::microscope)
    throw Failure{ExitCode::refused, "failed_precondition", "NOT_NOW",
                  "the indentation is at stage " + std::string(to_string(record.stage)) +
                      ": finish it with driftwise indent start " + a.file};
  if (record.tool != file.rules.tool)
    throw Failure{ExitCode::refused, "failed_precondition", reasons::kOtherTool,
                  "the indents were made with tool " + shown(record.tool) + ", " + a.file +
                      " names " + shown(file.rules.tool) +
                      ": its lever and force would be another tool's"};
  const auto indents = in_file(a.table, indentation::indents_seen(record, rows));
  if (!a.output.empty()) write_output_file(a.output, formats::write_indents_csv(indents));
  import_into_daemon(session, record.key, csv);
  const auto code = print_table(session, indents, file.tool, file.wanted_um);
  print_answers(session.console, record);
  return code;
}

}  // namespace

void add_indent_commands(CLI::App& app, Session& session) {
  CLI::App& indent =
      *app.add_subcommand("indent", "Indentation: two robots that touch, and the table of indents")
           ->require_subcommand(1);
  auto a = std::make_shared<IndentArguments>();
  const auto file = [a](CLI::App& command) {
    command.add_option("FILE", a->file, "indentation.toml")->required();
  };
  CLI::App& starting = add_command(
      indent, session, "start",
      "Aligns, finds the common zero and makes the indents (takes the lease); goes on where an "
      "earlier start ended",
      [&session, a] { return start(session, *a); });
  file(starting);
  starting.add_flag("--dry-run", a->dry_run,
                    "ask the cell whether it can be done and say what would be done; move nothing");
  starting.add_flag("--fresh", a->fresh,
                    "begin anew: the record of an earlier start, FILE.state.json, is overwritten");
  add_hold_options(starting, a->hold);
  add_command(indent, session, "list", "The indentations on the daemon's record, newest first",
              [&session] {
                print_indentation_list(session);
                return ExitCode::done;
              });
  CLI::App& showing = add_command(indent, session, "show",
                                  "The record of an indentation: stage, contacts, log, verdict",
                                  [&session, a] { return show(session, *a); });
  showing.add_option("WHAT", a->file, "its number on the daemon's record, or indentation.toml")
      ->required();
  showing.add_option("-o,--output", a->output,
                     "of a number: its record into FILE.state.json, to continue elsewhere");
  CLI::App& importing =
      add_command(indent, session, "import",
                  "The microscope's table onto the indents made: table, force, tool, verdict",
                  [&session, a] { return import(session, *a); });
  file(importing);
  importing.add_option("TABLE", a->table, "id, x_um, y_um, pixel_nm, ...: - for standard input")
      ->required();
  importing.add_option("-o,--output", a->output, "the table as CSV for `indent table`");
  CLI::App& tabled =
      add_command(indent, session, "table", "The table of indents of a file: needs no daemon",
                  [&session, a] { return table(session, *a); });
  tabled.add_option("FILE", a->file, "id, line, wanted_um, rx_arcsec, ...: - for standard input")
      ->required();
  tabled.add_option("--lever", a->lever_mm, "tip below the calibrated centre, mm (default 100)");
  tabled.add_option("--hardness", a->hardness_hv, "HV of the substrate (default 170)");
  tabled.add_option("--wanted", a->wanted_um, "accuracy wanted at the tool, um (default 1)");
}

}  // namespace driftwise::cli
