#include "clients/cli/commands/access/token_commands.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <memory>

#include "clients/cli/commands/access/role_text.h"
#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "clients/cli/core/validators.h"
#include "driftwise/v1/access_service.grpc.pb.h"

namespace driftwise::cli {
namespace {

using AccessStub = v1::AccessService::Stub;

struct TokenArguments {
  std::string name, role, output, id;
  double days = 0;
};

ExitCode who_am_i(const Session& session) {
  const auto identity = session.connect().ask(&AccessStub::GetIdentity, {}).identity();
  if (session.console.json) {
    session.console.print_json(json_from(identity));
    return ExitCode::done;
  }
  session.console.out << identity.name() << ", " << role_text(identity.role()) << ", by "
                      << identity.proof()
                      << (identity.credential().empty() ? "" : " " + identity.credential())
                      << ", from " << identity.from() << '\n';
  return ExitCode::done;
}

// Only the owner may read it, from its first byte on; a file that is there is not touched.
void write_token(const std::string& path, const std::string& text) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  const std::string line = text + "\n";
  const bool written =
      file >= 0 && ::write(file, line.data(), line.size()) == static_cast<ssize_t>(line.size());
  const std::string why = std::strerror(errno);
  if (file >= 0) ::close(file);
  if (!written)
    throw Failure{ExitCode::bad_input, "invalid_argument", "CANNOT_WRITE",
                  "cannot write " + path + ": " + why};
}

ExitCode create_token(const Session& session, const TokenArguments& a) {
  const auto connection = session.connect();
  if (!a.output.empty() && ::access(a.output.c_str(), F_OK) == 0)
    throw Failure{ExitCode::bad_input, "invalid_argument", "FILE_EXISTS",
                  a.output + " is there already: name another file, or remove it"};
  v1::CreateTokenRequest request;
  request.set_name(a.name);
  request.set_role(role_from_text(a.role));
  if (a.days > 0) {
    // In seconds: a time point of nanoseconds ends in the year 2262.
    const auto now = std::chrono::duration_cast<std::chrono::seconds>(
        std::chrono::system_clock::now().time_since_epoch());
    request.mutable_expire_time()->set_seconds(now.count() +
                                               static_cast<std::int64_t>(a.days * 86'400));
  }
  const auto made = connection.ask(&AccessStub::CreateToken, request);
  if (!a.output.empty()) write_token(a.output, made.text());
  if (session.console.json) {
    auto json = json_from(made);
    if (!a.output.empty()) json.erase("text");
    session.console.print_json(json);
    return ExitCode::done;
  }
  if (a.output.empty())
    session.console.out << made.text() << '\n';
  else
    session.console.out << "token " << made.token().id() << " is in " << a.output << '\n';
  session.console.err << "token " << made.token().id() << " of " << made.token().name() << ", "
                      << role_text(made.token().role())
                      << ": its text is kept nowhere else and cannot be shown again\n";
  return ExitCode::done;
}

ExitCode list_tokens(const Session& session) {
  const auto response = session.connect().ask(&AccessStub::ListTokens, {});
  if (session.console.json) {
    session.console.print_json(json_from(response));
    return ExitCode::done;
  }
  Table table({{"id"}, {"name"}, {"role"}, {"made (UTC)"}, {"by"}, {"ends (UTC)"}});
  for (const auto& token : response.tokens())
    table.add({token.id(), token.name(), role_text(token.role()), clock_text(token.create_time()),
               token.created_by(),
               token.has_expire_time() ? clock_text(token.expire_time()) : "-"});
  if (table.empty())
    session.console.out << "there are no tokens\n";
  else
    table.print(session.console.out, session.console.paint_out());
  return ExitCode::done;
}

ExitCode revoke_token(const Session& session, const TokenArguments& a) {
  v1::RevokeTokenRequest request;
  request.set_id(a.id);
  const auto gone = session.connect().ask(&AccessStub::RevokeToken, request).token();
  if (session.console.json)
    session.console.print_json(json_from(gone));
  else
    session.console.out << "token " << gone.id() << " of " << gone.name() << " is revoked\n";
  return ExitCode::done;
}

}  // namespace

void add_token_commands(CLI::App& app, Session& session) {
  add_command(app, session, "whoami", "As whom the daemon knows you, and your role",
              [&session] { return who_am_i(session); });
  CLI::App& token = *app.add_subcommand("token", "Tokens of programs and people; needs admin")
                         ->require_subcommand(1);
  auto a = std::make_shared<TokenArguments>();
  CLI::App& creating = add_command(token, session, "create", "Make a token; it is shown this once",
                                   [&session, a] { return create_token(session, *a); });
  creating.add_option("NAME", a->name, "who or what it is for: stands in the record")->required();
  creating.add_option("--role", a->role, "viewer, controller, operator, engineer or admin")
      ->required()
      ->check(CLI::IsMember(role_names()));
  creating.add_option("--days", a->days, "when it ends; else never")
      ->check(number_between(0.001, 36'500));
  creating.add_option("-o,--output", a->output, "file for it, mode 0600; else standard output");
  add_command(token, session, "list", "Every token, without its text",
              [&session] { return list_tokens(session); });
  CLI::App& revoking = add_command(token, session, "revoke", "No further call with this token",
                                   [&session, a] { return revoke_token(session, *a); });
  revoking.add_option("ID", a->id, "of the token")->required();
}

}  // namespace driftwise::cli
