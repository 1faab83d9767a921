#pragma once
// Serving plans: kept, checked, put in service. Checks run on the worker pool. Executor's thread.

#include <optional>
#include <string>
#include <vector>

#include "server/application/ports/caller.h"
#include "server/core/ports/awaitable.h"
#include "server/core/records/plan_records.h"
#include "server/core/result.h"
#include "server/plans/plan_check.h"

namespace driftwise::application {

struct PlanList {
  std::vector<PlanRecord> plans;  // oldest first
  std::optional<PlanId> serving;
  std::string trouble;  // why none serves although one was promoted, or what is wrong with it
};

struct PlanView {
  PlanRecord record;
  std::vector<std::string> steps;               // what happens to a wanted pose, a sentence each
  std::vector<PlanPromotionRecord> promotions;  // of any plan, oldest first
  bool serves = false;
};

struct PlanReport {
  plans::PlanCheck check;
  std::vector<std::string> steps;
};

class Plans {
 public:
  virtual ~Plans() = default;

  // The plan that a caller saw serve before asking for another one; none: no plan did.
  struct Seen {
    std::optional<PlanId> serving;
  };

  // Errors: those of formats::read_plan_file and PlanStore::add_plan.
  virtual Awaitable<Result<PlanRecord>> add(Caller caller, std::string text, std::string note,
                                            std::string request_id) = 0;
  virtual Awaitable<Result<PlanList>> list() = 0;
  virtual Awaitable<Result<PlanView>> get(PlanId id) = 0;
  // Of a stored plan, or of a text. Errors: those of get() and read_plan_file; what stands against
  // its promotion is the answer.
  virtual Awaitable<Result<PlanReport>> check(std::optional<PlanId> id, std::string text) = 0;
  // The plan that serves already is answered as it is: nothing is asked, nothing written.
  // confirmed: a person has read the questions. Errors: those of PlanCheck::refusal;
  // NEEDS_CONFIRMATION; PLAN_DAMAGED; STALE (another serves than was seen).
  virtual Awaitable<Result<PlanRecord>> promote(Caller caller, PlanId id, bool confirmed,
                                                std::optional<Seen> seen = {}) = 0;
  // To the plan that served before; none: no plan serves. from: the one that the caller saw
  // serve. Errors: failed_precondition NOTHING_TO_ROLL_BACK; STALE (another than `from` serves).
  virtual Awaitable<Result<std::optional<PlanRecord>>> roll_back(
      Caller caller, std::optional<PlanId> from = {}) = 0;
};

}  // namespace driftwise::application
