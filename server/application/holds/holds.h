#pragma once
// Conditions of the cell under which a run waits ([[hold]]), and a person's word that one of them
// does not count for a while. Executor's thread.

#include <string>
#include <vector>

#include "server/application/holds/hold_status.h"
#include "server/application/ports/caller.h"
#include "server/core/ports/awaitable.h"
#include "server/core/result.h"

namespace driftwise::application {

class Holds {
 public:
  virtual ~Holds() = default;

  virtual std::vector<HoldStatus> list() const = 0;  // in the order of the cell file
  // The rule suspends nothing for that long (cell time), or counts again at once (0). Not kept over
  // a restart of the daemon: then every rule counts.
  // Errors: not_found NO_SUCH_HOLD; invalid_argument BAD_DURATION (negative, above kMost_s),
  // REASON_MISSING; those of the store: the rule is set aside once that is in the audit, and a rule
  // that is put in force again counts in any case.
  virtual Awaitable<Result<HoldStatus>> set_aside(Caller caller, std::string name, double for_s,
                                                  std::string reason) = 0;

  static constexpr double kMost_s = 7 * 86'400;
};

}  // namespace driftwise::application
