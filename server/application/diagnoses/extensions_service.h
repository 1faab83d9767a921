#pragma once

#include <boost/asio/any_io_executor.hpp>

#include "server/application/diagnoses/diagnoses.h"
#include "server/application/diagnoses/extensions.h"
#include "server/application/models/models.h"
#include "server/application/models/promotions_service.h"
#include "server/application/plumbing/event_log.h"
#include "server/application/plumbing/store_reader.h"
#include "server/application/serving/serving.h"
#include "server/core/ports/async_mutex.h"
#include "server/correction/data_amendment.h"

namespace driftwise::application {

class ExtensionsService final : public Extensions {
 public:
  // worker: where models are fitted. All of them outlive this.
  ExtensionsService(const asio::any_io_executor& executor, const CellDescription& description,
                    Clock& clock, StoreReader& reader, StoreWriter& writer, EventLog& events,
                    Diagnoses& diagnoses, Models& models, PromotionsService& promotions,
                    Serving& serving, asio::any_io_executor worker)
      : changing_(executor),
        description_(description),
        clock_(clock),
        reader_(reader),
        writer_(writer),
        events_(events),
        diagnoses_(diagnoses),
        models_(models),
        promotions_(promotions),
        serving_(serving),
        worker_(std::move(worker)) {}

  Awaitable<Result<ExtensionPreview>> preview(AcceptRequest request) override;
  Awaitable<Result<ExtensionRecord>> accept(Caller caller, AcceptRequest request) override;
  Awaitable<Result<ExtensionRecord>> undo(Caller caller, DiagnosisId id) override;

 private:
  Awaitable<Result<std::vector<LengthChange>>> changes_in_all_runs(
      correction::DataAmendment amendment, std::vector<RunId> diagnosed);

  // Held from the look at what is in force to the end of what changes it.
  AsyncMutex changing_;
  const CellDescription& description_;
  Clock& clock_;
  StoreReader& reader_;
  StoreWriter& writer_;
  EventLog& events_;
  Diagnoses& diagnoses_;
  Models& models_;
  PromotionsService& promotions_;
  Serving& serving_;
  asio::any_io_executor worker_;
};

}  // namespace driftwise::application
