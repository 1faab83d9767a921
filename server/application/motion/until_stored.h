#pragma once
// Storing for a run that waits while the database takes nothing, for a cause that passes
// (plumbing/store_refusal.h): the same call succeeds later.

#include <type_traits>
#include <utility>

#include "server/application/motion/workbench.h"
#include "server/application/plumbing/store_refusal.h"
#include "server/core/try.h"

namespace driftwise::application {

// End of the wait for the disk before it takes the record.
enum class EndsWait {
  whatever_ends_a_step,  // a stop, an abort, the end of the daemon
  the_daemon_alone,      // what is lost otherwise: nothing measures it again
};

class DiskWait {
 public:
  DiskWait(RunScope& scope, EndsWait ends) : scope_(scope), ends_(ends) {}

  // The store refused: the run is waiting, with an event, and the next try is due when this
  // returns. Errors: those of RunControl::check, by `ends`; those of RunScope::enter_waiting.
  Awaitable<Result<void>> next_try(Error refusal);
  // The store took it: the run is running again. Errors: those of RunScope::leave_waiting.
  Awaitable<Result<void>> over();

 private:
  RunScope& scope_;
  EndsWait ends_;
  bool waiting_ = false, no_room_ = false;
};

// store(): the awaitable of one try; it is called again until the answer is anything but a refusal
// that passes. Without a run, of a movement by hand, that is an answer too: a person waits for it.
// Errors: those of the store and of DiskWait.
template <class Store>
std::invoke_result_t<Store&> until_stored(RunScope& scope, Store store,
                                          EndsWait ends = EndsWait::whatever_ends_a_step) {
  DiskWait wait(scope, ends);
  while (true) {
    auto storing = store();
    auto stored = co_await std::move(storing);
    if (!stored && scope.run && may_be_stored_later(stored.error())) {
      auto waiting = wait.next_try(stored.error());
      DRIFTWISE_CO_RETURN_IF_ERROR(co_await std::move(waiting));
      continue;
    }
    if (!stored) co_return stored;
    auto leaving = wait.over();
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await std::move(leaving));
    co_return stored;
  }
}

}  // namespace driftwise::application
