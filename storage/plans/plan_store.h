#pragma once
// Serving plans (storage/schema/schema_v11.h). Thread: the session's.

#include "server/core/ports/serving/plan_store.h"
#include "storage/sqlite/session.h"

namespace driftwise::storage {

class SqlitePlanStore final : public PlanStore {
 public:
  explicit SqlitePlanStore(Session& session) : session_(session) {}
  Result<PlanRecord> add_plan(const PlanRecord& plan) override;
  Result<PlanRecord> plan(PlanId id) override;
  Result<std::vector<PlanRecord>> plans() override;
  Result<void> add_plan_promotion(const PlanPromotionRecord& promotion) override;
  Result<std::vector<PlanPromotionRecord>> plan_promotions() override;

 private:
  Session& session_;
};

}  // namespace driftwise::storage
