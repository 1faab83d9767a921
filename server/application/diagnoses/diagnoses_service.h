#pragma once

#include <boost/asio/any_io_executor.hpp>

#include "server/application/datasets/datasets.h"
#include "server/application/diagnoses/diagnoses.h"
#include "server/application/diagnoses/diagnosis_desk.h"
#include "server/application/models/models.h"
#include "server/application/plumbing/store_reader.h"
#include "server/application/serving/serving.h"

namespace driftwise::application {

class DiagnosesService final : public Diagnoses {
 public:
  // background: where texts are read. All of them outlive this.
  DiagnosesService(const CellDescription& description, StoreReader& reader, DiagnosisDesk& desk,
                   Datasets& datasets, Models& models, const Serving& serving,
                   asio::any_io_executor background)
      : description_(description),
        reader_(reader),
        desk_(desk),
        datasets_(datasets),
        models_(models),
        serving_(serving),
        background_(std::move(background)) {}

  Awaitable<Result<DiagnosisView>> create(Caller caller, DiagnosisRequest request) override;
  Awaitable<Result<DiagnosisView>> get(DiagnosisId id) override;
  Awaitable<Result<std::vector<DiagnosisView>>> list() override;
  Awaitable<Result<DiagnosisView>> cancel(Caller caller, DiagnosisId id) override;
  std::shared_ptr<void> watch(std::function<void(const DiagnosisProgress&)> on_change) override;

  // A baseline that is not given is that of the model it begins from, a model that is not given the
  // one that serves. Errors: failed_precondition NO_MODEL.
  Awaitable<Result<void>> resolve_baseline(DiagnosisRequest& request);

 private:
  const CellDescription& description_;
  StoreReader& reader_;
  DiagnosisDesk& desk_;
  Datasets& datasets_;
  Models& models_;
  const Serving& serving_;
  asio::any_io_executor background_;
};

}  // namespace driftwise::application
