#include "clients/cli/commands/commissioning/commissioning_commands.h"
#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "driftwise/v1/commissioning_service.grpc.pb.h"

namespace driftwise::cli {
namespace {

using CommissioningStub = v1::CommissioningService::Stub;
constexpr double kCheckTakes_s = 120;  // devices that do not answer are waited for

Table::Cell finding_cell(v1::CheckVerdict finding) {
  switch (finding) {
    case v1::CHECK_VERDICT_GOOD:
      return {"good", Colour::good};
    case v1::CHECK_VERDICT_WARNING:
      return {"look", Colour::warn};
    case v1::CHECK_VERDICT_BAD:
      return {"bad", Colour::bad};
    default:
      return {"not declared", Colour::dim};
  }
}

ExitCode check(const Session& session) {
  const auto response =
      session.connect().ask(&CommissioningStub::CheckCell, v1::CheckCellRequest{}, kCheckTakes_s);
  const bool bad = response.verdict() == v1::CHECK_VERDICT_BAD;
  if (session.console.json) {
    session.console.print_json(json_from(response));
    return bad ? ExitCode::negative : ExitCode::done;
  }
  const Paint paint = session.console.paint_out();
  Table table({{"device"}, {"asked"}, {"found"}, {"expected"}, {"verdict"}, {"what to do"}});
  int good = 0, look = 0, wrong = 0, undeclared = 0;
  for (const auto& item : response.items()) {
    good += item.verdict() == v1::CHECK_VERDICT_GOOD;
    look += item.verdict() == v1::CHECK_VERDICT_WARNING;
    wrong += item.verdict() == v1::CHECK_VERDICT_BAD;
    undeclared += item.verdict() == v1::CHECK_VERDICT_UNKNOWN;
    table.add({item.device_id(), item.asked(), item.found(), item.expected(),
               finding_cell(item.verdict()), item.advice()});
  }
  table.print(session.console.out, paint);
  session.console.out << good << " good, " << look << " to look at, " << wrong << " bad, "
                      << undeclared << " with nothing declared to compare with\n";
  return bad ? ExitCode::negative : ExitCode::done;
}

ExitCode certificates(const Session& session) {
  const auto response =
      session.connect().ask(&CommissioningStub::ListCertificates, v1::ListCertificatesRequest{});
  bool overdue = false;
  for (const auto& one : response.certificates())
    overdue = overdue || (one.has_days_left() && one.days_left() < 0);
  if (session.console.json) {
    session.console.print_json(json_from(response));
    return overdue ? ExitCode::negative : ExitCode::done;
  }
  const Paint paint = session.console.paint_out();
  Table table({{"device"}, {"number"}, {"laboratory"}, {"date"}, {"due"}, {""}});
  for (const auto& one : response.certificates()) {
    Table::Cell left("");
    if (one.has_days_left() && one.days_left() < 0)
      left = {std::to_string(-one.days_left()) + " days overdue", Colour::bad};
    else if (one.has_days_left())
      left = std::to_string(one.days_left()) + " days left";
    table.add({one.device_id(), one.number(), one.laboratory(), one.date(),
               one.due_date().empty() ? "none stated" : one.due_date(), left});
  }
  if (!table.empty()) table.print(session.console.out, paint);
  std::string without;
  for (const auto& id : response.without()) without += (without.empty() ? "" : ", ") + id;
  if (!without.empty())
    session.console.out << "no [[certificate]] in the cell file for: " << without << '\n';
  return overdue ? ExitCode::negative : ExitCode::done;
}

}  // namespace

void add_cell_check_commands(CLI::App& app, Session& session) {
  CLI::App& cell =
      *app.add_subcommand("cell", "The cell against its description")->require_subcommand(1);
  add_command(cell, session, "check",
              "Asks every device and compares: identity, range, light, resolution, clock, "
              "certificate. Moves nothing",
              [&session] { return check(session); });
  add_command(cell, session, "certificates", "Certificates of the instruments, and what is overdue",
              [&session] { return certificates(session); });
}

}  // namespace driftwise::cli
