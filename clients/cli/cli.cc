#include "clients/cli/cli.h"

#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <exception>
#include <utility>

#include "clients/cli/commands/access/certificate_commands.h"
#include "clients/cli/commands/access/open_command.h"
#include "clients/cli/commands/access/token_commands.h"
#include "clients/cli/commands/cell/alarm_commands.h"
#include "clients/cli/commands/cell/cell_commands.h"
#include "clients/cli/commands/cell/hold_commands.h"
#include "clients/cli/commands/cell/watch_command.h"
#include "clients/cli/commands/commissioning/commissioning_commands.h"
#include "clients/cli/commands/configuration/configuration_commands.h"
#include "clients/cli/commands/data/data_commands.h"
#include "clients/cli/commands/data/remark_commands.h"
#include "clients/cli/commands/diagnoses/diagnose_command.h"
#include "clients/cli/commands/diagnoses/diagnosis_commands.h"
#include "clients/cli/commands/diagnoses/improve_commands.h"
#include "clients/cli/commands/indentation/indent_commands.h"
#include "clients/cli/commands/look_back/look_back_commands.h"
#include "clients/cli/commands/manual/command_tree.h"
#include "clients/cli/commands/manual/manual_commands.h"
#include "clients/cli/commands/models/fit_commands.h"
#include "clients/cli/commands/models/formula_commands.h"
#include "clients/cli/commands/models/model_commands.h"
#include "clients/cli/commands/plans/plan_commands.h"
#include "clients/cli/commands/procedure/procedure_command.h"
#include "clients/cli/commands/queue/queue_commands.h"
#include "clients/cli/commands/record/audit_commands.h"
#include "clients/cli/commands/record/backup_commands.h"
#include "clients/cli/commands/record/thin_command.h"
#include "clients/cli/commands/runs/report_command.h"
#include "clients/cli/commands/runs/run_commands.h"
#include "clients/cli/commands/targets/simulate_command.h"
#include "clients/cli/commands/targets/target_command.h"
#include "clients/cli/commands/trajectories/standard_commands.h"
#include "clients/cli/commands/watchdog/watchdog_command.h"
#include "clients/cli/core/session.h"
#include "clients/cli/core/validators.h"
#include "server/core/text/clean_text.h"
#include "server/formats/text/text.h"

namespace driftwise::cli {
namespace {

constexpr const char* kExamples =
    "Examples:\n"
    "  driftwise status                                   what the cell does now\n"
    "  driftwise run start weekend.csv --watch            measure, with a progress bar\n"
    "  driftwise fit --run 3 --model \"q ~ x + x^2 + T\"    learn the robot from a run\n"
    "  driftwise model promote 1                          let that model serve\n"
    "  driftwise target x=1.5                             motor coordinates for a pose\n"
    "  driftwise fit data.csv --model \"q ~ x + T\" --json  a file alone, no daemon needed\n"
    "\n"
    "driftwise: the command line of a Driftwise cell\n";

constexpr const char* kFooter =
    "Exit codes: 0 done, 1 done and the answer is no, 2 usage, 3 bad input, 4 daemon or device not "
    "reached,\n"
    "5 refused or failed, 130 interrupted. Manual: docs/cli.md";

void complain(const Console& console, const Failure& failure) {
  if (console.json) {
    const nlohmann::ordered_json json = {
        {"error",
         {{"code", failure.code}, {"reason", failure.reason}, {"message", failure.message}}}};
    console.err << json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) << '\n';
  } else {
    console.err << console.paint_err().bad("driftwise: ") << clean_text(failure.message) << '\n';
  }
  console.err << std::flush;
}

// The last command that was understood.
const CLI::App& deepest(const CLI::App& app) {
  const auto inner = app.get_subcommands();
  return inner.empty() ? app : deepest(*inner.back());
}
CLI::App& deepest(CLI::App& app) { return const_cast<CLI::App&>(deepest(std::as_const(app))); }

std::string what_is_wrong(const CLI::App& app, const CLI::App& named,
                          const CLI::ParseError& error) {
  const std::string what = error.what();
  if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::RequiredError)) {
    // CLI11 misses a command before it looks at what stands in its place.
    const auto unknown = app.remaining(true);
    if (!unknown.empty()) {
      std::vector<std::string> names;
      for (const CLI::App* one : named.get_subcommands({})) names.push_back(one->get_name());
      const auto nearest = formats::nearest_word(
          unknown.front(), std::vector<std::string_view>(names.begin(), names.end()));
      return "there is no '" + unknown.front() + "'" +
             (nearest.empty() ? "" : ": did you mean " + nearest + "?");
    }
    if (what == "A subcommand is required") {
      std::string verbs;
      for (const CLI::App* one : named.get_subcommands({}))
        verbs += (verbs.empty() ? "" : ", ") + one->get_name();
      return "expected one of " + verbs;
    }
  }
  const std::string cannot =
      "Could not convert: ";  // of numbers alone; "Could not convert: RUN = x"
  const auto equals = what.find(" = ");
  if (what.starts_with(cannot) && equals != std::string::npos)
    return what.substr(cannot.size(), equals - cannot.size()) + ": found '" +
           what.substr(equals + 3) + "', expected a number";
  return what;
}

// CLI11 has codes of its own; here a line that cannot be understood is 2, and --help and --version
// are 0.
int after_parse(const CLI::App& app, const CLI::ParseError& error, const Console& console) {
  if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) {
    app.exit(error, console.out, console.err);
    return static_cast<int>(ExitCode::done);
  }
  const CLI::App& named = deepest(app);
  std::string path = named.get_name();
  for (const CLI::App* one = &named; one != &app; path = one->get_name() + " " + path)
    one = one->get_parent();
  complain(console, {ExitCode::usage, "usage", "USAGE",
                     what_is_wrong(app, named, error) + " (" + path + " --help shows the way)"});
  return static_cast<int>(ExitCode::usage);
}

void add_shared_options(CLI::App& app, Session& session) {
  app.add_option("--server", session.server,
                 "host:port of the daemon; else $DRIFTWISE_SERVER, else driftwised.json here, else "
                 "127.0.0.1:50051");
  app.add_option("--tls-ca", session.way.tls_ca,
                 "TLS: certificate of the authority behind the daemon's; else $DRIFTWISE_TLS_CA");
  app.add_option("--tls-cert", session.way.tls_cert,
                 "TLS: your certificate, which names your role; else $DRIFTWISE_TLS_CERT");
  app.add_option("--tls-key", session.way.tls_key, "its key; else $DRIFTWISE_TLS_KEY");
  app.add_option("--token-file", session.way.token_file,
                 "file with a token (driftwise token create); else $DRIFTWISE_TOKEN_FILE");
  session.operator_name = session.console.variable("USER");
  app.add_option("--operator", session.operator_name, "who asks: stands in the record")
      ->default_str("$USER");
  app.add_option("--timeout", session.timeout_s,
                 "seconds to wait for an answer, or for a run's end")
      ->check(number_between(0.001, 31536000.0));
  app.add_flag("--json", session.console.json, "results for programs; docs/cli.md has the keys");
}

void add_everything(CLI::App& app, Session& session) {
  app.set_version_flag("--version", DRIFTWISE_VERSION);
  app.require_subcommand(1);
  app.fallthrough();  // the shared options may stand anywhere
  app.option_defaults()->always_capture_default(false);
  add_shared_options(app, session);
  add_status_commands(app, session);
  add_alarm_commands(app, session);
  add_hold_commands(app, session);
  add_watchdog_command(app, session);
  add_configuration_commands(app, session);
  add_token_commands(app, session);
  add_open_command(app, session);
  add_certificate_commands(app, session);
  add_watch_command(app, session);
  add_trajectory_commands(app, session);
  add_run_commands(app, session);
  add_queue_commands(app, session);
  add_motion_commands(app, session);
  add_jog_command(app, session);
  add_cell_check_commands(app, session);
  add_align_commands(app, session);
  add_channel_commands(app, session);
  add_data_commands(app, session);
  add_note_commands(app, session);
  add_formula_commands(app, session);
  add_fit_command(app, session);
  add_diagnose_command(app, session);
  add_diagnosis_commands(app, session);
  add_improve_commands(app, session);
  add_model_commands(app, session);
  add_procedure_command(app, session);
  add_design_command(app, session);
  add_plan_commands(app, session);
  add_indent_commands(app, session);
  add_target_command(app, session);
  add_simulate_command(app, session);
  add_standard_commands(app, session);
  add_report_command(app, session);
  add_audit_commands(app, session);
  add_backup_commands(app, session);
  add_thin_command(app, session);
  add_support_command(app, session);
  add_manual_commands(app, session);
  add_examples(app, kFooter);
}

// Words behind `watchdog --command` are another program's line, whatever it begins with; CLI11
// takes a word that begins with "-" for an option of its own unless it stands behind "=".
void take_command_of_watchdog(std::vector<std::string>& arguments) {
  const auto verb = std::ranges::find(arguments, "watchdog");
  const auto option = std::find(verb, arguments.end(), "--command");
  if (option == arguments.end() || option + 1 == arguments.end()) return;
  for (auto word = option + 1; word != arguments.end(); ++word) word->insert(0, "--command=");
  arguments.erase(option);
}

// Options of the command that name standard output as their file. What a private file holds is
// written by other means (token create).
std::vector<CLI::Option*> outputs_to_standard_output(CLI::App& app) {
  std::vector<CLI::Option*> found;
  for (const char* name : {"--output", "--residuals", "--report", "--separating", "--robot-out"}) {
    CLI::Option* option = app.get_option_no_throw(name);
    if (option != nullptr && option->count() == 1 && is_standard_output(option->results().front()))
      found.push_back(option);
  }
  return found;
}

// CLI11 wants the last word first.
void parse(CLI::App& app, std::vector<std::string> arguments) {
  take_command_of_watchdog(arguments);
  std::reverse(arguments.begin(), arguments.end());
  app.parse(std::move(arguments));
}

}  // namespace

std::optional<std::string> misunderstood(std::vector<std::string> arguments, Console& console) {
  Session session{console, nullptr, {}, {}, 0, {}};
  CLI::App app("", "driftwise");
  add_everything(app, session);
  try {
    parse(app, std::move(arguments));
  } catch (const CLI::ParseError& error) {
    return error.what();
  }
  return std::nullopt;
}

CommandText command_tree(Console& console) {
  Session session{console, nullptr, {}, {}, 0, {}};
  CLI::App app("", "driftwise");
  add_everything(app, session);
  return describe(app);
}

namespace {

// A file that is standard output has it alone: data with a page of text behind them are no data.
// page_aside: console is the one whose page goes to standard error already.
int perform(const std::vector<std::string>& arguments, Console& console, Interrupt* interrupt,
            bool page_aside) {
  Session session{console, interrupt, {}, {}, 0, {}};
  CLI::App app(kExamples, "driftwise");
  add_everything(app, session);
  try {
    parse(app, arguments);
  } catch (const CLI::ParseError& error) {
    return after_parse(app, error, console);
  }
  const auto outputs = outputs_to_standard_output(deepest(app));
  if (outputs.size() > 1) {
    complain(console, {ExitCode::usage, "usage", "USAGE",
                       outputs[0]->get_name() + " and " + outputs[1]->get_name() +
                           " are both standard output: give one of them the name of a file"});
    return static_cast<int>(ExitCode::usage);
  }
  if (!outputs.empty() && !page_aside) {
    Console page{
        console.err,        console.err,         console.err_is_terminal, console.err_is_terminal,
        console.err_width,  console.environment, console.working_folder,  false,
        console.err_height, console.in,          console.in_is_terminal,  console.await_answer};
    return perform(arguments, page, interrupt, true);
  }
  for (CLI::Option* output : outputs) {  // not "-", which some commands print to the page's stream
    output->clear();
    output->add_result("/dev/stdout");
    output->run_callback();
  }
  try {
    const ExitCode exit = session.action();
    console.out.flush();
    return static_cast<int>(exit);
  } catch (const Failure& failure) {
    complain(console, failure);
    return static_cast<int>(failure.exit);
  } catch (const std::exception& bug) {
    complain(console, {ExitCode::refused, "internal", "BUG",
                       std::string("this command failed inside: ") + bug.what() +
                           "; please report it with the command and its files"});
    return static_cast<int>(ExitCode::refused);
  }
}

}  // namespace

int run_cli(std::vector<std::string> arguments, Console& console, Interrupt* interrupt) {
  std::ostream& before = set_standard_output(console.out);
  const int exit = perform(arguments, console, interrupt, false);
  set_standard_output(before);
  return exit;
}

}  // namespace driftwise::cli
