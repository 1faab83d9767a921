// Verification of compensation: measured poses of runs against the commanded ones.

#include "server/application/checks/model_checks_service.h"
#include "server/application/datasets/amended_dataset.h"
#include "server/application/plumbing/run_on.h"
#include "server/application/ports/run_plan.h"
#include "server/core/try.h"
#include "server/formats/model/model_json.h"

namespace driftwise::application {
namespace {

using StoredModel = std::shared_ptr<const calibration::Model>;

struct VerifyMaterial {
  std::vector<diagnosis::RunToVerify> runs;
  StoredModel range;
};

Result<StoredModel> stored_model(Store& store, ModelId id) {
  DRIFTWISE_TRY(auto record, store.models().model(id));
  DRIFTWISE_TRY(auto model, formats::read_model_json(record.json));
  return std::make_shared<const calibration::Model>(std::move(model));
}

Result<VerifyMaterial> gather_runs(Store& store, const std::vector<RunId>& runs,
                                   std::optional<ModelId> range) {
  VerifyMaterial material;
  if (range) {
    DRIFTWISE_TRY(auto model, stored_model(store, *range));
    material.range = std::move(model);
  }
  for (const RunId id : runs) {
    DRIFTWISE_TRY(const auto record, store.runs().run(id));
    DRIFTWISE_TRY(auto data, amended_dataset(store, std::vector{id}));
    const Compensation compensation = compensation_of(record);
    diagnosis::RunToVerify run{id, compensation.compensated, compensation.model, nullptr,
                               std::move(data)};
    if (compensation.model) {
      DRIFTWISE_TRY(auto model, stored_model(store, *compensation.model));
      if (!model->geometry) run.model = std::move(model);  // its rows are judged by terms
    }
    material.runs.push_back(std::move(run));
  }
  return material;
}

}  // namespace

Awaitable<Result<diagnosis::Verification>> ModelChecksService::verify_runs(
    std::vector<RunId> runs, std::optional<ModelId> range) {
  DRIFTWISE_CO_TRY(auto material, co_await reader_.call(gather_runs, std::move(runs), range));
  co_return co_await run_on(
      worker_,
      [](const VerifyMaterial& of) { return diagnosis::verify_runs(of.runs, of.range.get()); },
      std::move(material));
}

}  // namespace driftwise::application
