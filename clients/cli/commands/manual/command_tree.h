#pragma once
// The commands and options as plain values, read from the parser's own description: what --help,
// the completions and the man pages are made from, so that none of them can say something else.

#include <CLI/App.hpp>
#include <string>
#include <vector>

namespace driftwise::cli {

struct OptionText {
  std::vector<std::string> names;  // "--output", "-o"; of a positional its one name: "FILE"
  std::string about;
  std::string value;                 // "TEXT", "INT"; empty: a flag
  std::string fallback;              // when it is not given; empty: none is said
  std::vector<std::string> choices;  // the only values, where there are such
  bool required = false, repeatable = false;
  bool takes_file = false;
};

struct CommandText {
  std::string name;  // "start"
  std::string path;  // "run start"; empty: the program
  std::string about;
  std::vector<OptionText> positionals, options;
  std::vector<CommandText> commands;
};

CommandText describe(const CLI::App& app);

// Calls visit with the command and each below it, parents first.
template <class Visit>
void each_command(const CommandText& command, Visit visit) {
  visit(command);
  for (const auto& below : command.commands) each_command(below, visit);
}

// Puts the examples of examples.h into the help of each command, above the exit codes.
void add_examples(CLI::App& app, const std::string& exit_codes);

}  // namespace driftwise::cli
