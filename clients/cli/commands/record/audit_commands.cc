#include "clients/cli/commands/record/audit_commands.h"

#include <memory>

#include "clients/cli/commands/record/record_file.h"
#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "driftwise/v1/record_service.grpc.pb.h"

namespace driftwise::cli {
namespace {

using RecordStub = v1::RecordService::Stub;
constexpr double kCheckTakes_s = 3600;  // a record of weeks, on a slow disk

struct AuditArguments {
  std::string database, kept;
  int limit = 0;
};

ExitCode list_acts(const Session& session, const AuditArguments& a) {
  v1::ListActsRequest request;
  request.set_limit(a.limit);
  const auto response = a.database.empty() ? session.connect().ask(&RecordStub::ListActs, request)
                                           : acts_of_file(a.database, request);
  if (session.console.json) {
    session.console.print_json(json_from(response));
    return ExitCode::done;
  }
  Table table({{"act", Align::right},
               {"when (UTC)"},
               {"who"},
               {"known by"},
               {"from"},
               {"what"},
               {"subject"},
               {"before"},
               {"after"},
               {"outcome"}});
  for (const auto& act : response.acts())
    table.add({std::to_string(act.id()), clock_text(act.time()), act.who(), act.proof(), act.from(),
               act.what(), act.subject(), act.before(), act.after(),
               act.outcome().empty() ? "done" : act.outcome()});
  if (table.empty())
    session.console.out << "no act of a person is on record\n";
  else
    table.print(session.console.out, session.console.paint_out());
  return ExitCode::done;
}

ExitCode show_head(const Session& session, const AuditArguments& a) {
  const auto response = a.database.empty() ? session.connect().ask(&RecordStub::GetChainHead, {})
                                           : head_of_file(a.database);
  if (session.console.json)
    session.console.print_json(json_from(response));
  else
    session.console.out << head_text(response.head()) << '\n';
  return ExitCode::done;
}

ExitCode verify_record(const Session& session, const AuditArguments& a) {
  v1::VerifyRecordRequest request;
  if (!a.kept.empty()) {
    const ChainHead kept = kept_head(a.kept);
    request.mutable_kept()->set_entry(kept.entry);
    request.mutable_kept()->set_hash(kept.hash);
  }
  const auto report = a.database.empty()
                          ? session.connect().ask(&RecordStub::VerifyRecord, request, kCheckTakes_s)
                          : verified_file(a.database, request);
  const bool intact = report.difference_count() == 0;
  const Console& console = session.console;
  if (console.json) {
    console.print_json(json_from(report));
  } else if (intact) {
    console.out << "the record is as it was stored: " << report.row_count() << " rows, chain of "
                << report.head().entry() << " entries\n"
                << "head " << head_text(report.head()) << '\n';
    if (a.kept.empty())
      console.out << "no kept head was given: a chain computed anew by somebody would pass "
                     "(--head HASH@N)\n";
  } else {
    console.out << console.paint_out().bad("the record was changed") << ": "
                << report.difference_count() << " differences, the first of them:\n";
    for (const auto& sentence : report.differences()) console.out << "  " << sentence << '\n';
  }
  if (!console.json && report.thinned_reading_count() > 0) {
    console.out << report.thinned_reading_count()
                << " readings of the environment were thinned; their digests are in the chain\n";
    for (const auto& sentence : report.thinned()) console.out << "  " << sentence << '\n';
  }
  return intact ? ExitCode::done : ExitCode::negative;
}

}  // namespace

void add_audit_commands(CLI::App& app, Session& session) {
  CLI::App& audit =
      *app.add_subcommand("audit", "Who did what, and whether the record was changed since")
           ->require_subcommand(1);
  auto a = std::make_shared<AuditArguments>();
  const auto with_file = [a](CLI::App& command) -> CLI::App& {
    command.add_option("--database", a->database,
                       "a database file, without a daemon; else the daemon's");
    return command;
  };
  CLI::App& listing = with_file(add_command(audit, session, "list", "Acts of people, newest first",
                                            [&session, a] { return list_acts(session, *a); }));
  listing.add_option("--limit", a->limit, "how many; else 100")->check(CLI::Range(1, 1000));
  with_file(add_command(audit, session, "head",
                        "The head of the chain over the record: keep it on another computer",
                        [&session, a] { return show_head(session, *a); }));
  CLI::App& verifying =
      with_file(add_command(audit, session, "verify",
                            "Compares the whole record with its chain; exit code 1: it was changed",
                            [&session, a] { return verify_record(session, *a); }));
  verifying.add_option("--head", a->kept, "HASH@N that was kept: finds a chain computed anew");
}

}  // namespace driftwise::cli
