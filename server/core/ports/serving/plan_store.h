#pragma once
// Serving plans: a part of server/core/ports/store.h, with its thread and its errors.

#include <vector>

#include "server/core/records/plan_records.h"
#include "server/core/result.h"

namespace driftwise {

class PlanStore {
 public:
  virtual ~PlanStore() = default;
  // Its id and version are ignored and given. The same text or request_id again: the record that is
  // there. Errors: not_found NO_SUCH_MODEL; failed_precondition REQUEST_ID_REUSED (with another
  // text).
  virtual Result<PlanRecord> add_plan(const PlanRecord& plan) = 0;
  virtual Result<PlanRecord> plan(PlanId id) = 0;       // Errors: not_found NO_SUCH_PLAN
  virtual Result<std::vector<PlanRecord>> plans() = 0;  // oldest first
  virtual Result<void> add_plan_promotion(const PlanPromotionRecord& promotion) = 0;
  // Oldest first; the last one serves.
  virtual Result<std::vector<PlanPromotionRecord>> plan_promotions() = 0;
};

}  // namespace driftwise
