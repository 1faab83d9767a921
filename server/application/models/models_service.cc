#include "server/application/models/models_service.h"

#include <fmt/format.h>

#include "server/application/datasets/amended_dataset.h"
#include "server/application/models/fit_options.h"
#include "server/application/models/model_integrity.h"
#include "server/application/plumbing/run_on.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/formats/csv/dataset_csv.h"
#include "server/formats/formula/formula.h"
#include "server/formats/model/model_json.h"

namespace driftwise::application {
namespace {

Result<std::vector<calibration::OfferResult>> offers_of(const Dataset& dataset,
                                                        const FitRequest& request,
                                                        const std::string& source) {
  DRIFTWISE_TRY(auto options, fit_options_from(request, dataset, source));
  DRIFTWISE_TRY(auto formula, formats::Formula::parse(request.formula));
  DRIFTWISE_TRY(auto candidates, formula.expand(dataset));
  options.candidates = std::move(candidates);
  DRIFTWISE_TRY(const auto model, calibration::fit(dataset, options));
  return calibration::weigh_offers(dataset, options, model,
                                   calibration::published_offers(dataset, options.candidates));
}

}  // namespace

Awaitable<Result<std::vector<calibration::OfferResult>>> ModelsService::weigh_offers(
    FitRequest request) {
  DRIFTWISE_CO_TRY(auto dataset, co_await datasets_.load(request.runs, request.csv));
  co_return co_await run_on(
      worker_,
      [](const Dataset& data, const FitRequest& asked) {
        return offers_of(data, asked, source_of(asked));
      },
      std::move(dataset), request);
}

Awaitable<Result<ModelRecord>> ModelsService::fit(Caller caller, FitRequest request) {
  DRIFTWISE_CO_TRY(auto dataset, co_await datasets_.load(request.runs, request.csv));
  // Those that the data just read rest on. A correction that comes or goes in between is named too.
  std::vector<CorrectionId> corrections;
  if (!request.runs.empty()) {
    DRIFTWISE_CO_TRY(auto found, co_await reader_.call(corrections_over, request.runs));
    corrections = std::move(found);
  }
  auto record = co_await run_on(
      worker_,
      [](const Dataset& data, const FitRequest& asked) {
        return fit_record(data, asked, source_of(asked));
      },
      std::move(dataset), request);
  if (!record) co_return record;
  record->corrections = std::move(corrections);
  record->created = clock_.now().utc;
  record->created_by = caller.name;
  DRIFTWISE_CO_TRY(auto id, co_await writer_.models().add_model(*record));
  events_.record(caller, "model.fitted",
                 fmt::format("{} fitted model {}: {}", caller.name, id.value, request.formula));
  co_return co_await get(id);  // the same fit again is the same model: its first record stands
}

Awaitable<Result<std::vector<ModelRecord>>> ModelsService::list() {
  auto models = co_await reader_.models().models();
  if (!models) co_return models;
  for (auto& model : *models)
    if (const auto whole = check_integrity(model); !whole) model.damage = whole.error().message;
  co_return models;
}

Awaitable<Result<ModelRecord>> ModelsService::get(ModelId id) {
  auto found = co_await reader_.models().model(id);
  if (!found && found.error().reason == reasons::kDatabaseDamaged) {
    ModelRecord unread;
    unread.id = id;
    unread.damage = found.error().message;
    found = std::move(unread);
  }
  if (!found) co_return found;
  DRIFTWISE_CO_RETURN_IF_ERROR(check_integrity(*found));
  co_return found;
}

}  // namespace driftwise::application
