#pragma once
// A question before something changes for others.

#include <string>
#include <vector>

#include "clients/cli/core/console.h"

namespace driftwise::cli {

// Shows the facts on standard error and asks "VERB? [y/N]". yes: --yes was given, nobody is asked.
// Throws Failure: usage NEEDS_YES where nobody can answer (no terminal, or --json); refused
// DECLINED for any answer but y or yes.
void confirm(const Console& console, bool yes, const std::string& title,
             const std::vector<std::string>& facts, const std::string& verb);

}  // namespace driftwise::cli
