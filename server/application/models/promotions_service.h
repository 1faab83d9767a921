#pragma once

#include <functional>
#include <string>

#include "server/application/models/models.h"
#include "server/application/models/promotions.h"
#include "server/application/plumbing/event_log.h"
#include "server/application/plumbing/store_reader.h"
#include "server/application/provenance/provenance.h"
#include "server/application/serving/serving.h"
#include "server/core/ports/async_mutex.h"

namespace driftwise::application {

class PromotionsService final : public Promotions {
 public:
  // served_another: called when another model, or none (false), has begun to serve. All of them
  // outlive this.
  PromotionsService(const asio::any_io_executor& executor, Clock& clock, StoreReader& reader,
                    StoreWriter& writer, EventLog& events, Models& models, Provenance& provenance,
                    Serving& serving, std::function<void(bool)> served_another)
      : changing_(executor),
        clock_(clock),
        reader_(reader),
        writer_(writer),
        events_(events),
        models_(models),
        provenance_(provenance),
        serving_(serving),
        served_another_(std::move(served_another)) {}

  Awaitable<Result<ModelRecord>> promote(Caller caller, ModelId id, bool confirmed,
                                         std::string reason, std::optional<Seen> seen) override;
  Awaitable<Result<std::optional<ModelRecord>>> roll_back(Caller caller,
                                                          std::optional<ModelId> from) override;

  // Whoever changes which model serves, on record and in memory, holds this from the decision to
  // the end.
  Awaitable<AsyncMutex::Lock> turn() { return changing_.lock(); }

  // What a roll-back would serve; without: models that are passed over. Errors: failed_precondition
  // NOTHING_TO_ROLL_BACK.
  Awaitable<Result<std::optional<ModelRecord>>> served_before(std::vector<ModelId> without = {});
  // The event of a promotion that is on record already.
  // before: the model that served; none: not known here, or none did.
  void announce(const Caller& caller, std::optional<ModelRecord> next, const std::string& action,
                std::optional<ModelId> before = {});
  // Why a model was promoted, as a note on it and an event.
  Awaitable<Result<void>> keep_reason(Caller caller, ModelId id, std::string reason);

 private:
  // In the caller's turn.
  Awaitable<Result<void>> put_in_service(Caller caller, std::optional<ModelRecord> next,
                                         std::string action);

  AsyncMutex changing_;
  Clock& clock_;
  StoreReader& reader_;
  StoreWriter& writer_;
  EventLog& events_;
  Models& models_;
  Provenance& provenance_;
  Serving& serving_;
  std::function<void(bool)> served_another_;
};

}  // namespace driftwise::application
