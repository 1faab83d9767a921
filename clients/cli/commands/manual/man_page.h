#pragma once
// Man pages out of the command tree: driftwise(1), and one page for each verb with all below it.
// Pure text in man(7); without a date, so that the same program makes the same page.

#include <map>
#include <string>

#include "clients/cli/commands/manual/command_tree.h"

namespace driftwise::cli {

// verb: one of the program's commands; empty: the page of the program. Nothing: no such verb.
std::string man_page(const CommandText& program, const std::string& verb,
                     const std::string& version);
// File name -> text: "driftwise.1", "driftwise-run.1", ...
std::map<std::string, std::string> man_pages(const CommandText& program,
                                             const std::string& version);

}  // namespace driftwise::cli
