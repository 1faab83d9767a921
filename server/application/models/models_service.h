#pragma once

#include <boost/asio/any_io_executor.hpp>

#include "server/application/datasets/datasets.h"
#include "server/application/models/models.h"
#include "server/application/plumbing/event_log.h"
#include "server/application/plumbing/store_reader.h"

namespace driftwise::application {

class ModelsService final : public Models {
 public:
  // worker: where fits run. All of them outlive this.
  ModelsService(const CellDescription& description, Clock& clock, StoreReader& reader,
                StoreWriter& writer, EventLog& events, Datasets& datasets,
                asio::any_io_executor worker)
      : description_(description),
        clock_(clock),
        reader_(reader),
        writer_(writer),
        events_(events),
        datasets_(datasets),
        worker_(std::move(worker)) {}

  Awaitable<Result<ModelRecord>> fit(Caller caller, FitRequest request) override;
  Awaitable<Result<KinematicFit>> create_kinematic(Caller caller,
                                                   KinematicRequest request) override;
  Awaitable<Result<std::vector<calibration::OfferResult>>> weigh_offers(
      FitRequest request) override;
  Awaitable<Result<FormulaCheck>> check_formula(FitRequest request) override;
  Awaitable<Result<ModelResiduals>> residuals(ModelId id, std::vector<RunId> runs,
                                              std::string csv) override;
  Awaitable<Result<std::vector<ListedModel>>> list() override;
  Awaitable<Result<ModelRecord>> get(ModelId id) override;

 private:
  // Puts it on record with what its data rest on. what: of the event.
  Awaitable<Result<ModelRecord>> store(Caller caller, ModelRecord record,
                                       std::vector<CorrectionId> corrections, std::string what);
  Awaitable<Result<std::vector<CorrectionId>>> corrections_under(std::vector<RunId> runs);

  const CellDescription& description_;
  Clock& clock_;
  StoreReader& reader_;
  StoreWriter& writer_;
  EventLog& events_;
  Datasets& datasets_;
  asio::any_io_executor worker_;
  ModelList list_;  // of the reader's thread
};

}  // namespace driftwise::application
