#include "clients/cli/commands/configuration/configuration_commands.h"

#include <memory>

#include "clients/cli/core/confirm.h"
#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "clients/cli/pages/configuration_text.h"
#include "driftwise/v1/configuration_service.grpc.pb.h"

namespace driftwise::cli {
namespace {

using ConfigurationStub = v1::ConfigurationService::Stub;

struct ConfigurationArguments {
  std::string hash, compare, note;
  bool text = false, yes = false;
};

v1::ListConfigurationsResponse starts_of(const Connection& connection, int limit) {
  v1::ListConfigurationsRequest request;
  request.set_limit(limit);
  return connection.ask(&ConfigurationStub::ListConfigurations, request);
}

ExitCode list_configurations(const Session& session) {
  const auto response = starts_of(session.connect(), 0);
  if (session.console.json) {
    session.console.print_json(json_from(response));
    return ExitCode::done;
  }
  Table table({{"start", Align::right},
               {"when (UTC)"},
               {"configuration"},
               {"program"},
               {"differences", Align::right},
               {"answer"}});
  for (const auto& start : response.starts())
    table.add({std::to_string(start.id()), clock_text(start.start_time()), start.hash(),
               start.version(), std::to_string(start.changes_size()),
               !start.asks() ? "not needed"
               : start.has_accept_time()
                   ? "accepted " + utc_text(start.accept_time()) + " by " + start.accepted_by()
                   : "open"});
  if (table.empty())
    session.console.out << "no start is on record\n";
  else
    table.print(session.console.out, session.console.paint_out());
  return ExitCode::done;
}

template <class Changes>
void print_configuration_changes(const Console& console, const Changes& changes) {
  for (const auto& change : changes)
    console.out << (change.asks() ? console.paint_out().warn("asks      ") : "recorded  ")
                << change_text(change) << '\n';
}

// Without a hash: the present one, and the difference that the newest start found.
ExitCode show_configuration(const Session& session, const ConfigurationArguments& a) {
  const auto connection = session.connect();
  v1::GetConfigurationRequest request;
  request.set_hash(a.hash);
  request.set_compare_hash(a.compare);
  const auto response = connection.ask(&ConfigurationStub::GetConfiguration, request);
  if (session.console.json) {
    auto json = json_from(response);
    if (a.hash.empty()) json["start"] = json_from(starts_of(connection, 1))["starts"][0];
    session.console.print_json(json);
    return ExitCode::done;
  }
  const Console& console = session.console;
  if (a.text) {
    console.out << response.text();
    return ExitCode::done;
  }
  console.out << console.paint_out().bold("configuration " + response.hash()) << '\n';
  if (a.hash.empty() && a.compare.empty()) {
    const auto starts = starts_of(connection, 1);
    if (starts.starts().empty()) return ExitCode::done;
    const auto& start = starts.starts(0);
    if (start.before_hash().empty() || start.before_hash() == start.hash())
      console.out << "in force" << (start.before_hash().empty() ? ", the first" : ", as before")
                  << '\n';
    else if (start.changes().empty())
      console.out << "the same by meaning as " << start.before_hash() << '\n';
    else
      console.out << "since " << start.before_hash() << ":\n";
    print_configuration_changes(console, start.changes());
    if (starts.open_question())
      console.out << "a person has to accept it: driftwise configuration accept\n";
    return ExitCode::done;
  }
  if (response.changes().empty())
    console.out << "the same by meaning as " << response.compared_hash() << '\n';
  else
    console.out << "to " << response.compared_hash() << ":\n";
  print_configuration_changes(console, response.changes());
  return ExitCode::done;
}

ExitCode accept_configuration(const Session& session, const ConfigurationArguments& a) {
  const auto connection = session.connect();
  const auto starts = starts_of(connection, 1);
  if (!starts.open_question())
    throw Failure{ExitCode::refused, "failed_precondition", "NO_QUESTION",
                  "the cell file puts no question: there is nothing to accept"};
  const auto& start = starts.starts(0);
  std::vector<std::string> facts;
  for (const auto& change : start.changes())
    if (change.asks()) facts.push_back(change_text(change));
  facts.push_back(
      "from then on the unfinished run continues, and models that use these parts serve");
  confirm(session.console, a.yes,
          "configuration " + start.hash() + " against " + start.before_hash() + ":", facts,
          "Accept it");
  v1::AcceptConfigurationRequest request;
  request.set_hash(start.hash());
  request.set_note(a.note);
  const auto accepted = connection.ask(&ConfigurationStub::AcceptConfiguration, request).start();
  if (session.console.json)
    session.console.print_json(json_from(accepted));
  else
    session.console.out << "configuration " << accepted.hash() << " is accepted\n";
  return ExitCode::done;
}

}  // namespace

void add_configuration_commands(CLI::App& app, Session& session) {
  CLI::App& configuration =
      *app.add_subcommand("configuration", "Cell files that were in force, and what changed")
           ->require_subcommand(1);
  auto a = std::make_shared<ConfigurationArguments>();
  add_command(configuration, session, "list", "Every start of the daemon, newest first",
              [&session] { return list_configurations(session); });
  CLI::App& showing = add_command(configuration, session, "show",
                                  "A cell file and what differs from it, by meaning",
                                  [&session, a] { return show_configuration(session, *a); });
  showing.add_option("HASH", a->hash, "of the cell file; else the present one");
  showing.add_option("--against", a->compare,
                     "hash of the one to compare with; else the present one");
  showing.add_flag("--text", a->text, "print the file as it was read");
  CLI::App& accepting = add_command(configuration, session, "accept",
                                    "A person has seen the differences: runs and targets go on",
                                    [&session, a] { return accept_configuration(session, *a); });
  accepting.add_option("--note", a->note, "why, for the record");
  accepting.add_flag("--yes", a->yes, "ask nothing: for scripts");
}

}  // namespace driftwise::cli
