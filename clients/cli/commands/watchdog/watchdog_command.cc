#include "clients/cli/commands/watchdog/watchdog_command.h"

#include <chrono>
#include <csignal>
#include <memory>

#include "clients/cli/core/validators.h"
#include "clients/cli/core/value_or_throw.h"
#include "server/core/cell_time.h"
#include "server/core/text/clean_text.h"
#include "server/notify/outside_notifier.h"
#include "server/notify/secret_file.h"
#include "server/watchdog/watchdog.h"

namespace driftwise::cli {
namespace {

struct WatchdogArguments {
  std::string listen = "127.0.0.1:9470", heads = "heads.log", heard_token, certificate, key;
  double silent_after_s = 120;
  std::vector<std::string> cells;
  ReceiverDescription receiver;
};

std::string now_text() {
  using std::chrono::seconds;
  const auto since = std::chrono::system_clock::now().time_since_epoch();
  return to_iso8601(CellTime{std::chrono::duration_cast<seconds>(since).count() * 1'000'000'000});
}

Failure usage(const std::string& message) { return {ExitCode::usage, "usage", "USAGE", message}; }

void check(const WatchdogArguments& a) {
  const auto& r = a.receiver;
  const int ways = int{!r.webhook.empty()} + int{!r.smtp.empty()} + int{!r.command.empty()};
  if (ways != 1)
    throw usage("found " + std::to_string(ways) +
                " of --webhook, --smtp and --command, expected exactly one: whom to tell");
  if (!r.smtp.empty() && (r.from.empty() || r.to.empty()))
    throw usage("--smtp needs --from and --to: who sends the mail, and who gets it");
  if (r.user.empty() != r.password_file.empty())
    throw usage("--user and --password-file belong together");
  if (a.certificate.empty() != a.key.empty())
    throw usage("--certificate and --key belong together");
}

ExitCode run(const Session& session, WatchdogArguments a) {
  check(a);
  watchdog::WatchdogOptions options;
  options.listen = a.listen;
  options.heads = a.heads;
  options.expect = a.cells;
  options.silent_after_s = a.silent_after_s;
  options.receiver = a.receiver;
  options.receiver.name = "watchdog";
  if (!a.heard_token.empty()) options.token = value_or_throw(notify::read_secret(a.heard_token));
  if (!a.certificate.empty())
    options.tls = value_or_throw(tls::TlsMaterial::open(
        {a.certificate, a.key, ""}, tls::ClientCertificate::ignored, "http/1.1"));
  std::signal(SIGPIPE, SIG_IGN);
  if (session.interrupt != nullptr) session.interrupt->attend();
  notify::OutsideNotifier notifier;
  const auto say = [&session](const std::string& line) {
    session.console.err << now_text() << ' ' << clean_line(line) << '\n' << std::flush;
  };
  const auto done = watchdog::run_watchdog(
      std::move(options), notifier,
      [&](const std::string& address) {
        say("waits for signs of life at " + address + "; heads go to " + a.heads);
      },
      say, [&session] { return session.interrupt != nullptr && session.interrupt->raised(); });
  if (!done) throw failure_of(done.error());
  return ExitCode::interrupted;
}

}  // namespace

void add_watchdog_command(CLI::App& app, Session& session) {
  auto a = std::make_shared<WatchdogArguments>();
  CLI::App& command = add_command(
      app, session, "watchdog",
      "On another machine: raises the alarm when a cell falls silent, keeps its record's heads",
      [&session, a] { return run(session, *a); });
  command.add_option("--listen", a->listen, "where cells reach it (127.0.0.1:9470)");
  command
      .add_option("--silent-after", a->silent_after_s,
                  "seconds without a sign of life until the alarm (120)")
      ->check(number_between(1, 86'400));
  command.add_option("--heads", a->heads, "file of the heads of the record's chain (heads.log)");
  command.add_option("--cell", a->cells, "a cell that is expected from the start; may be repeated");
  command.add_option("--secret", a->heard_token,
                     "file (mode 0600) of the token that cells must show; beyond loopback needed");
  command.add_option("--certificate", a->certificate, "PEM of this door's TLS certificate");
  command.add_option("--key", a->key, "PEM of its key");
  auto& receiver = a->receiver;
  command.add_option("--webhook", receiver.webhook, "URL that takes Alertmanager's webhook");
  command.add_option("--webhook-token", receiver.token_file, "file (mode 0600) of its token");
  command.add_option("--smtp", receiver.smtp, "mail server: smtps://mail.example.org:465");
  command.add_option("--from", receiver.from, "sender of the mail");
  command.add_option("--to", receiver.to, "address that gets it; may be repeated");
  command.add_option("--user", receiver.user, "at the mail server");
  command.add_option("--password-file", receiver.password_file, "file (mode 0600) of the password");
  command.add_option("--ca-file", receiver.ca_file, "PEM of the receiver's authority");
  command.add_option(
      "--command", receiver.command,
      "the rest of the line: program and arguments, {title} and {text} filled in, without "
      "a shell");
  command.add_option("--repeat", receiver.repeat_h, "hours until an alarm is told again (4)")
      ->check(number_between(0, 8784));
}

}  // namespace driftwise::cli
