#pragma once
// Completion scripts for bash, zsh and fish: commands, options, values that are words of a list,
// file names where a file is wanted. Pure text out of the command tree.

#include <string>

#include "clients/cli/commands/manual/command_tree.h"

namespace driftwise::cli {

std::string bash_completion(const CommandText& program);
std::string zsh_completion(const CommandText& program);
std::string fish_completion(const CommandText& program);

}  // namespace driftwise::cli
