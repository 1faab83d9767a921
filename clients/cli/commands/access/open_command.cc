#include "clients/cli/commands/access/open_command.h"

#include "driftwise/v1/access_service.grpc.pb.h"
#include "driftwise/v1/cell_service.grpc.pb.h"

namespace driftwise::cli {
namespace {

// The link is printed and not handed to a browser: arguments of a program can be read by every user
// of the computer.
ExitCode print_link(const Session& session) {
  const auto connection = session.connect();
  const std::string page = connection.ask(&v1::CellService::Stub::GetStatus, {}).web_address();
  if (page.empty())
    throw Failure{
        ExitCode::refused, "failed_precondition", "NO_WEB_PAGE",
        "the daemon serves no page: set http in [cell], or in [access] with certificates"};
  const auto link = connection.ask(&v1::AccessService::Stub::CreatePageLink, {}).link();
  const std::string address = page + "log-in#" + link;
  if (session.console.json)
    session.console.print_json({{"link", address}});
  else
    session.console.out << address << '\n';
  session.console.err << "the link logs one browser in as you, once, within two minutes\n";
  return ExitCode::done;
}

}  // namespace

void add_open_command(CLI::App& app, Session& session) {
  add_command(app, session, "open", "A link that opens the page as you, once",
              [&session] { return print_link(session); });
}

}  // namespace driftwise::cli
