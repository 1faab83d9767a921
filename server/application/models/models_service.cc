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

// On the reader's thread: a text of megabytes is hashed.
Result<ModelRecord> whole_model(Store& store, ModelId id) {
  auto found = store.models().model(id);
  if (!found && found.error().reason == reasons::kDatabaseDamaged) {
    ModelRecord unread;
    unread.id = id;
    unread.damage = found.error().message;
    found = std::move(unread);
  }
  if (!found) return found;
  DRIFTWISE_RETURN_IF_ERROR(check_integrity(*found));
  return found;
}

Result<std::vector<ListedModel>> listed_models(Store& store, ModelList* list) {
  return list->of(store);
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
  DRIFTWISE_CO_TRY(request.set_names, co_await datasets_.set_names(request.runs, request.csv));
  DRIFTWISE_CO_TRY(auto dataset, co_await datasets_.load(request.runs, request.csv));
  auto looking = corrections_under(request.runs);
  DRIFTWISE_CO_TRY(auto corrections, co_await std::move(looking));
  auto record = co_await run_on(
      worker_,
      [](const Dataset& data, const FitRequest& asked) {
        return fit_record(data, asked, source_of(asked));
      },
      std::move(dataset), request);
  if (!record) co_return record;
  auto storing =
      store(std::move(caller), std::move(*record), std::move(corrections), request.formula);
  co_return co_await std::move(storing);
}

Awaitable<Result<KinematicFit>> ModelsService::create_kinematic(Caller caller,
                                                                KinematicRequest request) {
  std::optional<Dataset> data;
  if (request.has_data()) {
    auto loading = datasets_.load(request.fit.runs, request.fit.csv);
    DRIFTWISE_CO_TRY(data, co_await std::move(loading));
  }
  auto looking = corrections_under(request.fit.runs);
  DRIFTWISE_CO_TRY(auto corrections, co_await std::move(looking));
  DRIFTWISE_CO_TRY(auto made, co_await run_on(
                                  worker_,
                                  [cell = &description_](const std::optional<Dataset>& rows,
                                                         const KinematicRequest& asked) {
                                    return kinematic_record(rows, asked, *cell);
                                  },
                                  std::move(data), request));
  const std::string what = made.model.name;
  auto storing = store(std::move(caller), std::move(made.model), std::move(corrections), what);
  DRIFTWISE_CO_TRY(made.model, co_await std::move(storing));
  co_return made;
}

// Those that the data just read rest on. A correction that comes or goes in between is named too.
Awaitable<Result<std::vector<CorrectionId>>> ModelsService::corrections_under(
    std::vector<RunId> runs) {
  if (runs.empty()) co_return std::vector<CorrectionId>{};
  co_return co_await reader_.call(corrections_over, std::move(runs));
}

Awaitable<Result<ModelRecord>> ModelsService::store(Caller caller, ModelRecord record,
                                                    std::vector<CorrectionId> corrections,
                                                    std::string what) {
  record.corrections = std::move(corrections);
  record.created = clock_.now().utc;
  record.created_by = caller.name;
  DRIFTWISE_CO_TRY(auto id, co_await writer_.models().add_model(record));
  auto stored = co_await get(id);
  if (stored && stored->created.utc_ns != record.created.utc_ns)  // the first record stands
    what += fmt::format(" (the same content again, stored as '{}')", stored->name);
  events_.record(caller, "model.fitted",
                 fmt::format("{} fitted model {}: {}", caller.name, id.value, what));
  co_return stored;
}

Awaitable<Result<std::vector<ListedModel>>> ModelsService::list() {
  co_return co_await reader_.call(listed_models, &list_);
}

Awaitable<Result<ModelRecord>> ModelsService::get(ModelId id) {
  co_return co_await reader_.call(whole_model, id);
}

}  // namespace driftwise::application
