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
  std::vector<std::vector<correction::RowOrigin>> origins;  // of the rows of each
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
    DRIFTWISE_TRY(auto amended, amended_data(store, std::vector{id}));
    const Compensation compensation = compensation_of(record);
    diagnosis::RunToVerify run{id, compensation.compensated, compensation.model, nullptr,
                               std::move(amended.data)};
    material.origins.push_back(std::move(amended.origins));
    if (compensation.model) {
      DRIFTWISE_TRY(auto model, stored_model(store, *compensation.model));
      if (!model->geometry) run.model = std::move(model);  // its rows are judged by terms
    }
    material.runs.push_back(std::move(run));
  }
  return material;
}

// The row with the largest error is then a row of the run's plan: its place in the dataset counts
// passages, and no command takes it.
Result<diagnosis::Verification> verified(const VerifyMaterial& of) {
  auto found = diagnosis::verify_runs(of.runs, of.range.get());
  if (!found) return found;
  for (std::size_t i = 0; i < found->runs.size() && i < of.origins.size(); ++i)
    for (auto& one : found->runs[i].coordinates)
      if (one.largest_row < of.origins[i].size())
        one.largest_row = static_cast<std::size_t>(of.origins[i][one.largest_row].row);
  return found;
}

}  // namespace

Awaitable<Result<diagnosis::Verification>> ModelChecksService::verify_runs(
    std::vector<RunId> runs, std::optional<ModelId> range) {
  DRIFTWISE_CO_TRY(auto material, co_await reader_.call(gather_runs, std::move(runs), range));
  co_return co_await run_on(worker_, verified, std::move(material));
}

}  // namespace driftwise::application
