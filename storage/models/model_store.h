#pragma once

#include "server/core/ports/store.h"
#include "storage/sqlite/session.h"

namespace driftwise::storage {

// Inside the caller's transaction. The same hash again: the same id.
ModelId insert_model(Session& session, const ModelRecord& model);
void insert_promotion(Session& session, const PromotionRecord& promotion);
void require_model(Session& session, ModelId id);  // throws not_found NO_SUCH_MODEL

class SqliteModelStore final : public ModelStore {
 public:
  explicit SqliteModelStore(Session& session) : session_(session) {}
  Result<ModelId> add_model(const ModelRecord& model) override;
  Result<ModelRecord> model(ModelId id) override;
  Result<std::vector<ModelRecord>> models() override;
  Result<void> add_promotion(const PromotionRecord& promotion) override;
  Result<std::vector<PromotionRecord>> promotions() override;

 private:
  Session& session_;
};

}  // namespace driftwise::storage
