#include "server/application/models/promotions_service.h"

#include <fmt/format.h>

#include <algorithm>

#include "server/application/plumbing/crash_point.h"
#include "server/application/provenance/promotion_questions.h"
#include "server/core/reasons.h"
#include "server/core/records/served_in_order.h"
#include "server/core/try.h"

namespace driftwise::application {

namespace {

ServedInOrder<ModelId> models_served(const std::vector<PromotionRecord>& history) {
  ServedInOrder<ModelId> served;
  for (const auto& step : history) {
    if (step.action == "rollback")
      served.rolled_back(step.model);
    else if (step.model)
      served.promoted(*step.model);
  }
  return served;
}

std::string named(std::optional<ModelId> model) {
  return model ? fmt::format("model {}", model->value) : std::string("no model");
}

}  // namespace

Awaitable<Result<void>> PromotionsService::put_in_service(Caller caller,
                                                          std::optional<ModelRecord> next,
                                                          std::string action) {
  std::optional<ModelRecord> previous;
  if (const auto serving = serving_.model())
    if (auto record = co_await models_.get(*serving)) previous = std::move(*record);
  // First see that it can serve, then write it down: what stands in the record is what serves.
  if (auto ok = co_await serving_.serve(next); !ok) co_return ok;
  PromotionRecord promotion{next ? std::optional(next->id) : std::nullopt, clock_.now().utc,
                            caller.name, action};
  auto stored = co_await writer_.models().add_promotion(promotion);
  if (!stored) {
    static_cast<void>(co_await serving_.serve(previous));
    co_return stored;
  }
  announce(caller, std::move(next), action, previous ? std::optional(previous->id) : std::nullopt);
  co_return Result<void>{};
}

void PromotionsService::announce(const Caller& caller, std::optional<ModelRecord> next,
                                 const std::string& action, std::optional<ModelId> before) {
  const auto name = [](const std::optional<ModelId>& model) {
    return model ? fmt::format("model {}", model->value) : std::string();
  };
  events_.record(
      caller, "model." + action,
      next ? fmt::format("model {} '{}' serves, by {}", next->id.value, next->name, caller.name)
           : fmt::format("no model serves, by {}", caller.name),
      {}, {"serving model", name(before), name(next ? std::optional(next->id) : std::nullopt)});
  served_another_(next.has_value());
}

Awaitable<Result<void>> PromotionsService::keep_reason(Caller caller, ModelId id,
                                                       std::string reason) {
  NoteSubject on;
  on.model = id;
  NoteRecord note{0, on, "promoted, because: " + reason, clock_.now(), caller.name, caller.peer};
  DRIFTWISE_CO_TRY(const auto stored, co_await writer_.remarks().add_note(std::move(note)));
  events_.record(caller, "note.added",
                 fmt::format("{} on model {}: {}", caller.name, id.value, stored.text));
  co_return Result<void>{};
}

Awaitable<Result<ModelRecord>> PromotionsService::promote(Caller caller, ModelId id, bool confirmed,
                                                          std::string reason,
                                                          std::optional<Seen> seen) {
  auto record = co_await models_.get(id);
  if (!record || serving_.model() == id) co_return record;  // it serves already
  auto looking = provenance_.ground_of_model(id);
  DRIFTWISE_CO_TRY(const auto ground, co_await std::move(looking));
  if (!confirmed) DRIFTWISE_CO_RETURN_IF_ERROR(confirmation_of(ground.promotion_questions));
  if (reason.empty()) DRIFTWISE_CO_RETURN_IF_ERROR(reason_for(ground.questions_for_a_reason));
  const auto held = co_await turn();
  if (seen && serving_.model() != seen->serving)
    co_return fail(ErrorCode::failed_precondition, reasons::kStale,
                   fmt::format("{} serves by now, where {} was seen to serve: model {} was not "
                               "promoted; look at what serves, then promote it again",
                               named(serving_.model()), named(seen->serving), id.value));
  for (const auto& question : ground.promotion_questions)
    events_.record(
        caller, "model.confirmed",
        fmt::format("{} promotes model {} although {}", caller.name, id.value, question));
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await put_in_service(caller, *record, "promote"));
  if (!reason.empty())
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await keep_reason(std::move(caller), id, std::move(reason)));
  co_return record;
}

Awaitable<Result<std::optional<ModelRecord>>> PromotionsService::served_before(
    std::vector<ModelId> without) {
  DRIFTWISE_CO_TRY(auto history, co_await reader_.models().promotions());
  auto served = models_served(history);
  if (served.ids().empty())
    co_return fail(ErrorCode::failed_precondition, reasons::kNothingToRollBack,
                   "no model serves: there is none to take back");
  while (served.before() && std::ranges::find(without, *served.before()) != without.end())
    served.rolled_back(served.before());
  std::optional<ModelRecord> previous;
  if (const auto before = served.before()) {
    DRIFTWISE_CO_TRY(auto record, co_await models_.get(*before));
    previous = std::move(record);
  }
  co_return previous;
}

Awaitable<Result<std::optional<ModelRecord>>> PromotionsService::roll_back(
    Caller caller, std::optional<ModelId> from) {
  const auto held = co_await turn();
  if (from && serving_.model() != from)
    co_return fail(
        ErrorCode::failed_precondition, reasons::kStale,
        fmt::format("{} serves by now, where model {} was to be taken back: nothing was rolled "
                    "back; look at the list of promotions, then try again",
                    named(serving_.model()), from->value));
  auto finding = served_before();
  auto previous = co_await std::move(finding);
  if (!previous) co_return previous;
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await put_in_service(std::move(caller), *previous, "rollback"));
  co_return previous;
}

}  // namespace driftwise::application
