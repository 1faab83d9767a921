#include "clients/cli/core/confirm.h"

#include <istream>

namespace driftwise::cli {

void confirm(const Console& console, bool yes, const std::string& title,
             const std::vector<std::string>& facts, const std::string& verb) {
  if (!console.json || !yes) {
    console.err << console.paint_err().bold(title) << '\n';
    for (const auto& fact : facts) console.err << "  " << fact << '\n';
  }
  if (yes) return;
  if (console.in == nullptr || !console.in_is_terminal || console.json)
    throw Failure{ExitCode::usage, "usage", "NEEDS_YES",
                  "nobody can be asked here: read what is above, and give --yes"};
  console.err << verb << "? [y/N] " << std::flush;
  if (console.await_answer && !console.await_answer())
    throw Failure{ExitCode::interrupted, "cancelled", "INTERRUPTED",
                  "interrupted: nothing was changed"};
  std::string answer;
  std::getline(*console.in, answer);
  if (answer == "y" || answer == "Y" || answer == "yes") return;
  throw Failure{ExitCode::refused, "cancelled", "DECLINED", "nothing was changed"};
}

std::optional<std::int64_t> confirm_rollback(const Console& console, bool yes,
                                             const ServedIds& served,
                                             const RollbackQuestion& question) {
  if (served.ids().empty()) return std::nullopt;
  const auto before = served.before();
  confirm(console, yes,
          question.what + " " + std::to_string(served.ids().back()) +
              " serves no longer, for every controller:",
          before ? question.facts_of_return(*before)
                 : std::vector<std::string>{"no " + question.what + " served before it: " +
                                            question.none + " until one is promoted"},
          "Roll back");
  return served.ids().back();
}

}  // namespace driftwise::cli
