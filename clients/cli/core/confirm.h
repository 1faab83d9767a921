#pragma once
// A question before something changes for others.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "clients/cli/core/console.h"
#include "server/core/records/served_in_order.h"

namespace driftwise::cli {

// Shows the facts on standard error and asks "VERB? [y/N]". yes: --yes was given, nobody is asked.
// Throws Failure: usage NEEDS_YES where nobody can answer (no terminal, or --json); refused
// DECLINED for any answer but y or yes; interrupted at Ctrl-C.
void confirm(const Console& console, bool yes, const std::string& title,
             const std::vector<std::string>& facts, const std::string& verb);

using ServedIds = ServedInOrder<std::int64_t>;

// A rollback names nothing, so it shows which one serves no longer and which one serves again.
struct RollbackQuestion {
  std::string what;  // "model"
  std::string none;  // consequence where none served before
  std::function<std::vector<std::string>(std::int64_t)> facts_of_return;
};
// confirm() of a rollback; returns the one that serves, for the request to name. None serves:
// nobody is asked, the daemon says that there is none.
std::optional<std::int64_t> confirm_rollback(const Console& console, bool yes,
                                             const ServedIds& served,
                                             const RollbackQuestion& question);

}  // namespace driftwise::cli
