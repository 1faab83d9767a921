#include "clients/cli/commands/manual/manual_commands.h"

#include <filesystem>
#include <memory>

#include "clients/cli/commands/manual/completion.h"
#include "clients/cli/commands/manual/man_page.h"

namespace driftwise::cli {
namespace {

ExitCode print_completion(const Session& session, const CLI::App& app, const std::string& shell) {
  const CommandText program = describe(app);
  session.console.out << (shell == "bash"  ? bash_completion(program)
                          : shell == "zsh" ? zsh_completion(program)
                                           : fish_completion(program));
  return ExitCode::done;
}

ExitCode write_pages(const Session& session, const CLI::App& app, const std::string& verb,
                     const std::string& folder) {
  const CommandText program = describe(app);
  if (folder.empty()) {
    const std::string page = man_page(program, verb, DRIFTWISE_VERSION);
    if (page.empty())
      throw Failure{ExitCode::bad_input, "not_found", "NO_VERB",
                    "there is no verb '" + verb + "': driftwise --help lists them"};
    session.console.out << page;
    return ExitCode::done;
  }
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  if (failed)
    throw Failure{ExitCode::bad_input, "invalid_argument", "BAD_FOLDER",
                  folder + ": cannot be made: " + failed.message()};
  for (const auto& [name, text] : man_pages(program, DRIFTWISE_VERSION))
    write_output_file((std::filesystem::path(folder) / name).string(), text);
  return ExitCode::done;
}

}  // namespace

void add_manual_commands(CLI::App& app, Session& session) {
  auto shell = std::make_shared<std::string>();
  CLI::App& completion =
      add_command(app, session, "completion", "A completion script for your shell",
                  [&session, &app, shell] { return print_completion(session, app, *shell); });
  completion.add_option("SHELL", *shell, "bash, zsh or fish")
      ->required()
      ->check(CLI::IsMember({"bash", "zsh", "fish"}));

  auto verb = std::make_shared<std::string>(), folder = std::make_shared<std::string>();
  CLI::App& man = add_command(
      app, session, "man", "The manual as man pages",
      [&session, &app, verb, folder] { return write_pages(session, app, *verb, *folder); });
  CLI::Option* of = man.add_option("VERB", *verb, "of this verb; else of the program");
  man.add_option("--into", *folder, "write every page into this folder")->excludes(of);
}

}  // namespace driftwise::cli
