#include "clients/cli/commands/record/backup_commands.h"

#include <chrono>
#include <filesystem>
#include <memory>

#include "clients/cli/commands/record/record_file.h"
#include "clients/cli/core/confirm.h"
#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/text.h"
#include "clients/cli/core/value_or_throw.h"
#include "driftwise/v1/record_service.grpc.pb.h"
#include "server/core/utc_map.h"
#include "server/formats/text/kept_stop.h"
#include "storage/audit/record_copy.h"
#include "storage/sqlite/file_owner.h"

namespace driftwise::cli {
namespace {

constexpr double kBackupTakes_s = 3600;  // a record of weeks, onto a slow disk

struct RestoreArguments {
  std::string copy, database, kept;
  bool replace = false, may_be_another = false, yes = false;
};

void print_copy(const Console& console, const v1::RecordCopy& copy, const std::string& what) {
  if (console.json) {
    console.print_json(json_from(copy));
    return;
  }
  console.out << what << copy.path() << ": " << copy.row_count() << " rows, "
              << fixed(static_cast<double>(copy.byte_count()) / 1e6, 1) << " MB, checked\n";
  if (copy.head().entry() > 0)
    console.out << "head " << head_text(copy.head()) << " (keep it on another computer)\n";
}

ExitCode back_up(const Session& session) {
  const auto copy =
      session.connect().ask(&v1::RecordService::Stub::BackUpRecord, {}, kBackupTakes_s).copy();
  print_copy(session.console, copy, "");
  return ExitCode::done;
}

// "cell.db.before-20261122T093000Z"
std::string name_of_present(const std::string& database) {
  const auto now = std::chrono::duration_cast<std::chrono::nanoseconds>(
      std::chrono::system_clock::now().time_since_epoch());
  std::string instant = to_iso8601(CellTime{now.count()}).substr(0, 19);
  std::erase_if(instant, [](char c) { return c == '-' || c == ':'; });
  return database + ".before-" + instant + "Z";
}

// A run that the copy holds, and campaigns that wait in it, are of another day: the daemon stops
// the axes first, and both wait for a person. It is a stop of this record alone: a daemon that
// works on another one beside it goes on. Result: its path. It is there before the copy is at its
// place: a restore that is interrupted leaves no record that moves by itself.
std::string keep_stop(const Session& session, const RestoreArguments& a) {
  const auto now = std::chrono::duration_cast<std::chrono::nanoseconds>(
      std::chrono::system_clock::now().time_since_epoch());
  const std::string path = std::filesystem::absolute(formats::kept_stop_of_record(a.database))
                               .lexically_normal()
                               .string();
  const std::string who = "the restore of " + base_name(a.copy) + " by " +
                          (session.operator_name.empty() ? "somebody" : session.operator_name);
  write_output_file(path, formats::write_kept_stop({who, to_iso8601(UtcTime{now.count()})}));
  storage::give_to_owner_of_folder(path);
  return path;
}

void tell_of_stop(const Session& session, const std::string& path) {
  session.console.err << "the first start with this record moves nothing: " << path
                      << " holds a run of the copy and the queue until `driftwise run resume` and "
                         "`driftwise queue release`; it goes where the record goes\n";
}

ExitCode restore(const Session& session, const RestoreArguments& a) {
  storage::Restore wanted{a.copy, a.database, {}, {}};
  if (!a.kept.empty()) wanted.kept = kept_head(a.kept);
  const bool is_there = std::filesystem::exists(a.database);
  if (a.replace && is_there) {
    wanted.present_kept_as = name_of_present(a.database);
    confirm(session.console, a.yes, "record " + a.database + ":",
            {"becomes what " + a.copy + " holds; what was measured after that is not in it",
             "the present record is kept as " + wanted.present_kept_as},
            "Restore it");
  }
  wanted.may_be_another = a.may_be_another;
  std::string stop;
  wanted.before_names_change = [&] { stop = keep_stop(session, a); };
  const auto restored = storage::restore_record(wanted);
  if (!restored) {
    auto failure = failure_of(restored.error());
    if (restored.error().reason == "FILE_EXISTS" && !a.replace)
      failure.message += "; --replace keeps it under another name and puts the copy in its place";
    if (restored.error().reason == "OTHER_RECORD")
      failure.message += "; --other-record puts it there all the same";
    throw Failure(failure);
  }
  print_copy(session.console, copy_message(*restored), "restored ");
  tell_of_stop(session, stop);
  return ExitCode::done;
}

}  // namespace

void add_backup_commands(CLI::App& app, Session& session) {
  add_command(app, session, "backup",
              "Copies the record while the cell works, checks the copy, prints where it is",
              [&session] { return back_up(session); });
  auto a = std::make_shared<RestoreArguments>();
  CLI::App& restoring =
      add_command(app, session, "restore", "Puts a copy of a record in its place; without a daemon",
                  [&session, a] { return restore(session, *a); });
  restoring.add_option("COPY", a->copy, "a backup")->required();
  restoring.add_option("--database", a->database, "where to: [cell] database of the cell file")
      ->required();
  restoring.add_option("--head", a->kept, "HASH@N that was kept: the copy must hold it");
  restoring.add_flag("--replace", a->replace,
                     "a record that is there is kept under another name; else it is refused");
  restoring.add_flag("--other-record", a->may_be_another,
                     "with --replace: the copy may be of another record than the present one");
  restoring.add_flag("--yes", a->yes, "ask nothing: for scripts");
}

}  // namespace driftwise::cli
