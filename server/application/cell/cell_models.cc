// Models: fit, promote, roll back.

#include <fmt/format.h>

#include "server/application/cell/cell_application.h"
#include "server/application/datasets/amended_dataset.h"
#include "server/application/models/fit_options.h"
#include "server/application/models/model_integrity.h"
#include "server/application/plumbing/run_on.h"
#include "server/application/provenance/promotion_questions.h"
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

// Which model served before each promotion, oldest first; the last is the one that serves now.
std::vector<ModelId> served_in_order(const std::vector<PromotionRecord>& history) {
  std::vector<ModelId> stack;
  for (const auto& step : history) {
    if (step.action == "rollback") {
      if (!stack.empty()) stack.pop_back();
    } else if (step.model) {
      stack.push_back(*step.model);
    }
  }
  return stack;
}

}  // namespace

Awaitable<Result<Dataset>> CellApplication::fit_data(FitRequest request) {
  if (request.runs.empty() == request.csv.empty())
    co_return fail(ErrorCode::invalid_argument, reasons::kNoData,
                   "a fit needs runs or a dataset, one of the two");
  if (request.csv.empty()) co_return co_await reader_.call(amended_dataset, request.runs);
  co_return co_await run_on(
      background(),
      [](const std::string& csv) {
        return formats::read_dataset_csv(csv, "dataset", {}, formats::kRequestLimits);
      },
      request.csv);
}

Awaitable<Result<std::vector<calibration::OfferResult>>> CellApplication::weigh_offers(
    FitRequest request) {
  DRIFTWISE_CO_TRY(auto dataset, co_await fit_data(request));
  co_return co_await run_on(
      worker_thread_.executor(),
      [](const Dataset& data, const FitRequest& asked) {
        return offers_of(data, asked, source_of(asked));
      },
      std::move(dataset), request);
}

Awaitable<Result<ModelRecord>> CellApplication::fit(Caller caller, FitRequest request) {
  DRIFTWISE_CO_TRY(auto dataset, co_await fit_data(request));
  // Those that the data just read rest on. A correction that comes or goes in between is named too.
  std::vector<CorrectionId> corrections;
  if (!request.runs.empty()) {
    DRIFTWISE_CO_TRY(auto found, co_await reader_.call(corrections_over, request.runs));
    corrections = std::move(found);
  }
  auto record = co_await run_on(
      worker_thread_.executor(),
      [](const Dataset& data, const FitRequest& asked) {
        return fit_record(data, asked, source_of(asked));
      },
      std::move(dataset), request);
  if (!record) co_return record;
  record->corrections = std::move(corrections);
  record->created = clock_->now().utc;
  record->created_by = caller.name;
  DRIFTWISE_CO_TRY(auto id, co_await writer_.models().add_model(*record));
  events_.record(caller, "model.fitted",
                 fmt::format("{} fitted model {}: {}", caller.name, id.value, request.formula));
  co_return co_await model(id);  // the same fit again is the same model: its first record stands
}

Awaitable<Result<std::vector<ModelRecord>>> CellApplication::models() {
  auto models = co_await reader_.models().models();
  if (!models) co_return models;
  for (auto& model : *models)
    if (const auto whole = check_integrity(model); !whole) model.damage = whole.error().message;
  co_return models;
}

Awaitable<Result<ModelRecord>> CellApplication::model(ModelId id) {
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

Awaitable<Result<std::vector<PromotionRecord>>> CellApplication::promotions() {
  co_return co_await reader_.models().promotions();
}

Awaitable<Result<void>> CellApplication::put_in_service(Caller caller,
                                                        std::optional<ModelRecord> next,
                                                        std::string action) {
  std::optional<ModelRecord> previous;
  if (const auto serving = serving_.model())
    if (auto record = co_await model(*serving)) previous = std::move(*record);
  // First see that it can serve, then write it down: what stands in the record is what serves.
  if (auto ok = co_await serving_.serve(next); !ok) co_return ok;
  PromotionRecord promotion{next ? std::optional(next->id) : std::nullopt, clock_->now().utc,
                            caller.name, action};
  auto stored = co_await writer_.models().add_promotion(promotion);
  if (!stored) {
    static_cast<void>(co_await serving_.serve(previous));
    co_return stored;
  }
  tell_serving(caller, std::move(next), action);
  co_return Result<void>{};
}

void CellApplication::tell_serving(const Caller& caller, std::optional<ModelRecord> next,
                                   const std::string& action) {
  events_.record(
      caller, "model." + action,
      next ? fmt::format("model {} '{}' serves, by {}", next->id.value, next->name, caller.name)
           : fmt::format("no model serves, by {}", caller.name));
  check_trouble_.clear();
  if (next) {
    tasks_.spawn(check_serving_model(std::nullopt));
  }
}

Awaitable<Result<ModelRecord>> CellApplication::promote(Caller caller, ModelId id, bool confirmed) {
  auto record = co_await model(id);
  if (!record) co_return record;
  auto looking = ground_of_model(id);
  DRIFTWISE_CO_TRY(const auto ground, co_await std::move(looking));
  if (!confirmed) DRIFTWISE_CO_RETURN_IF_ERROR(confirmation_of(ground.promotion_questions));
  for (const auto& question : ground.promotion_questions)
    events_.record(
        caller, "model.confirmed",
        fmt::format("{} promotes model {} although {}", caller.name, id.value, question));
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await put_in_service(std::move(caller), *record, "promote"));
  co_return record;
}

Awaitable<Result<std::optional<ModelRecord>>> CellApplication::served_before() {
  DRIFTWISE_CO_TRY(auto history, co_await promotions());
  auto stack = served_in_order(history);
  if (stack.empty())
    co_return fail(ErrorCode::failed_precondition, reasons::kNothingToRollBack,
                   "no model serves: there is none to take back");
  stack.pop_back();
  std::optional<ModelRecord> previous;
  if (!stack.empty()) {
    DRIFTWISE_CO_TRY(auto record, co_await model(stack.back()));
    previous = std::move(record);
  }
  co_return previous;
}

Awaitable<Result<std::optional<ModelRecord>>> CellApplication::roll_back(Caller caller) {
  auto finding = served_before();
  auto previous = co_await std::move(finding);
  if (!previous) co_return previous;
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await put_in_service(std::move(caller), *previous, "rollback"));
  co_return previous;
}

}  // namespace driftwise::application
