#pragma once
// The command line as a function, so that tests drive it as a person does.

#include <optional>
#include <string>
#include <vector>

#include "clients/cli/commands/manual/command_tree.h"
#include "clients/cli/core/console.h"
#include "clients/cli/core/interrupt.h"

namespace driftwise::cli {

// arguments: without the program's name. interrupt: null where nobody can press Ctrl-C.
// Returns the exit code; never throws for what a user or the world can do wrong.
int run_cli(std::vector<std::string> arguments, Console& console, Interrupt* interrupt = nullptr);

// What is wrong with a line, nothing where it is understood. Runs nothing.
std::optional<std::string> misunderstood(std::vector<std::string> arguments, Console& console);
// All commands and options, as they are.
CommandText command_tree(Console& console);

}  // namespace driftwise::cli
