#pragma once
// The model in service: promoted, rolled back. Executor's thread.

#include <optional>
#include <string>

#include "server/application/ports/caller.h"
#include "server/core/ports/awaitable.h"
#include "server/core/records/records.h"
#include "server/core/result.h"

namespace driftwise::application {

class Promotions {
 public:
  virtual ~Promotions() = default;

  // The model that a caller saw serve before asking for another one; none: no model did.
  struct Seen {
    std::optional<ModelId> serving;
  };

  // The model that serves already is answered as it is: nothing is asked, nothing written.
  // confirmed: a person has read ModelGround::promotion_questions. reason: why it serves all the
  // same, kept as a note on the model. Errors: failed_precondition NEEDS_CONFIRMATION, with the
  // questions; REASON_REQUIRED, with those that confirmed alone does not answer; STALE (another
  // serves than was seen).
  virtual Awaitable<Result<ModelRecord>> promote(Caller caller, ModelId id, bool confirmed = false,
                                                 std::string reason = {},
                                                 std::optional<Seen> seen = {}) = 0;
  // To the model that served before; none: no model serves. from: the one that the caller saw
  // serve. Errors: failed_precondition NOTHING_TO_ROLL_BACK; STALE (another than `from` serves).
  virtual Awaitable<Result<std::optional<ModelRecord>>> roll_back(
      Caller caller, std::optional<ModelId> from = {}) = 0;
};

}  // namespace driftwise::application
