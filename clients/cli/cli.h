#pragma once
// The command line as a function, so that tests drive it as a person does.

#include <string>
#include <vector>

#include "clients/cli/console.h"
#include "clients/cli/interrupt.h"

namespace driftwise::cli {

// arguments: without the program's name. interrupt: null where nobody can press Ctrl-C.
// Returns the exit code; never throws for what a user or the world can do wrong.
int run_cli(std::vector<std::string> arguments, Console& console, Interrupt* interrupt = nullptr);

}  // namespace driftwise::cli
