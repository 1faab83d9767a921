// What compensation achieved: runs as they were measured, against what was wanted.

#include "server/application/cell/cell_application.h"
#include "server/application/datasets/amended_dataset.h"
#include "server/application/runs/run_plan.h"
#include "server/formats/model/model_json.h"

namespace driftwise::application {
namespace {

using StoredModel = std::shared_ptr<const calibration::Model>;

struct VerifyMaterial {
  std::vector<diagnosis::RunToVerify> runs;
  StoredModel range;
};

Result<StoredModel> stored_model(Store& store, ModelId id) {
  auto record = store.models().model(id);
  if (!record) return tl::unexpected(record.error());
  auto model = formats::read_model_json(record->json);
  if (!model) return tl::unexpected(model.error());
  return std::make_shared<const calibration::Model>(std::move(*model));
}

Result<VerifyMaterial> gather_runs(Store& store, const std::vector<RunId>& runs,
                                   std::optional<ModelId> range) {
  VerifyMaterial material;
  if (range) {
    auto model = stored_model(store, *range);
    if (!model) return tl::unexpected(model.error());
    material.range = std::move(*model);
  }
  for (const RunId id : runs) {
    const auto record = store.runs().run(id);
    if (!record) return tl::unexpected(record.error());
    auto data = amended_dataset(store, std::vector{id});
    if (!data) return tl::unexpected(data.error());
    const Compensation compensation = compensation_of(*record);
    diagnosis::RunToVerify run{id, compensation.compensated, compensation.model, nullptr,
                               std::move(*data)};
    if (compensation.model) {
      auto model = stored_model(store, *compensation.model);
      if (!model) return tl::unexpected(model.error());
      run.model = std::move(*model);
    }
    material.runs.push_back(std::move(run));
  }
  return material;
}

}  // namespace

Awaitable<Result<diagnosis::Verification>> CellApplication::verify_runs(
    std::vector<RunId> runs, std::optional<ModelId> range) {
  auto gathering = reader_.call(
      [runs = std::move(runs), range](Store& store) { return gather_runs(store, runs, range); });
  auto material = co_await std::move(gathering);
  if (!material) co_return tl::unexpected(material.error());
  auto shared = std::make_shared<VerifyMaterial>(std::move(*material));
  auto verifying = run_on(worker_thread_.executor(), [shared]() {
    return diagnosis::verify_runs(shared->runs, shared->range.get());
  });
  co_return co_await std::move(verifying);
}

}  // namespace driftwise::application
