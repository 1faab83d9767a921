#pragma once

#include <string>
#include <utility>
#include <vector>

#include "server/application/models/models.h"
#include "server/application/plans/joint_serving.h"
#include "server/application/plans/plans.h"
#include "server/application/plumbing/event_log.h"
#include "server/application/plumbing/store_reader.h"
#include "server/application/provenance/provenance.h"
#include "server/core/ports/async_mutex.h"

namespace driftwise::application {

class PlansService final : public Plans {
 public:
  // All of them outlive this.
  PlansService(const asio::any_io_executor& executor, const CellDescription& description,
               Clock& clock, StoreReader& reader, StoreWriter& writer, EventLog& events,
               Models& models, Provenance& provenance, JointServing& serving,
               asio::any_io_executor worker)
      : changing_(executor),
        description_(description),
        clock_(clock),
        reader_(reader),
        writer_(writer),
        events_(events),
        models_(models),
        provenance_(provenance),
        serving_(serving),
        worker_(std::move(worker)) {}

  Awaitable<Result<PlanRecord>> add(Caller caller, std::string text, std::string note,
                                    std::string request_id) override;
  Awaitable<Result<PlanList>> list() override;
  Awaitable<Result<PlanView>> get(PlanId id) override;
  Awaitable<Result<PlanReport>> check(std::optional<PlanId> id, std::string text) override;
  Awaitable<Result<PlanRecord>> promote(Caller caller, PlanId id, bool confirmed,
                                        std::optional<Seen> seen) override;
  Awaitable<Result<std::optional<PlanRecord>>> roll_back(Caller caller,
                                                         std::optional<PlanId> from) override;

  // Serves what was promoted last, after a start of the daemon.
  Awaitable<Result<void>> restore();

 private:
  struct Loaded {
    plans::ServingPlan plan;
    plans::ModelsById models;
    std::map<ModelId, std::vector<std::string>> tools;
  };
  // missing_is_empty: a model that is not there is left out, for the check to name it.
  Awaitable<Result<Loaded>> load(plans::ServingPlan plan, bool missing_is_empty);
  // Questions of each of its models, as if it were to serve by itself.
  Awaitable<Result<std::vector<plans::PlanFinding>>> questions_of_models(
      const Loaded& loaded) const;
  Awaitable<Result<plans::ServingPlan>> whole_plan(const PlanRecord& record) const;
  // In the caller's turn.
  Awaitable<Result<void>> put_in_service(Caller caller, std::optional<PlanRecord> next,
                                         std::string action);

  // Held from the decision which plan serves until it is on record and serves.
  AsyncMutex changing_;
  const CellDescription& description_;
  Clock& clock_;
  StoreReader& reader_;
  StoreWriter& writer_;
  EventLog& events_;
  Models& models_;
  Provenance& provenance_;
  JointServing& serving_;
  asio::any_io_executor worker_;
};

}  // namespace driftwise::application
