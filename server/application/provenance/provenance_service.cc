#include "server/application/provenance/provenance_service.h"

#include <algorithm>

#include "server/application/datasets/amended_dataset.h"
#include "server/application/datasets/extension_preview.h"
#include "server/application/datasets/instruments.h"
#include "server/application/datasets/joined_runs.h"
#include "server/application/provenance/promotion_material.h"
#include "server/core/try.h"
#include "server/formats/model/model_json.h"

namespace driftwise::application {
namespace {

Result<RunGround> ground_of(Store& store, RunId run,
                            const std::vector<CorrectionRecord>& corrections) {
  RunGround ground;
  DRIFTWISE_TRY(auto used, store.configurations().of_run(run));
  DRIFTWISE_TRY(const auto record, store.runs().run(run));
  ground.configurations = std::move(used);
  const auto inside = corrections_in(record);
  for (const auto& correction : corrections) {
    if (std::ranges::find(inside, correction.id) == inside.end()) {
      if (!correction.in_force()) continue;
      auto whole = amendment_of(store, correction);
      if (!whole) continue;
      DRIFTWISE_TRY(const auto amendment, held_for(store, std::move(*whole), {&run, 1}));
      if (!concerns(amendment, record)) continue;
    }
    auto& mine = ground.corrections.emplace_back(correction);
    std::erase_if(mine.changes, [run](const LengthChange& change) { return change.run != run; });
  }
  return ground;
}

// Whether this cell measured a run after the model was made, which any check of it looks at.
Result<bool> is_judged_later(Store& store, const ModelRecord& model) {
  constexpr int kNewest = 20;
  DRIFTWISE_TRY(const auto runs, store.runs().runs(kNewest, 0));
  return std::ranges::any_of(runs, [&model](const RunRecord& run) {
    return run.created > model.created && run.accepted > 0 && run.reason != "imported";
  });
}

Result<ModelGround> ground_of(Store& store, ModelId id, const CellDescription& present,
                              const Clock& clock) {
  DRIFTWISE_TRY(const auto record, store.models().model(id));
  DRIFTWISE_TRY(const auto model, formats::read_model_json(record.json));
  ModelGround ground;
  ground.present_hash = present.hash;
  DRIFTWISE_TRY(auto material,
                promotion_material(store, model.lineage.runs, record.created, present));
  DRIFTWISE_TRY(const auto corrections, store.extensions().corrections());
  for (const auto& correction : corrections)
    if (std::ranges::find(record.corrections, correction.id) != record.corrections.end()) {
      auto& mine = ground.corrections.emplace_back(correction);
      std::erase_if(mine.changes, [&model](const LengthChange& change) {
        return std::ranges::find(model.lineage.runs, change.run) == model.lineage.runs.end();
      });
    }
  DRIFTWISE_TRY(material.judged_later, is_judged_later(store, record));
  material.rests_on = ground.corrections;
  auto asked = questions_before_serving(model, material, present,
                                        [&clock](CellTime at) { return clock.utc(at); });
  ground.configurations = std::move(material.configurations);
  ground.measured_under = std::move(material.measured_under);
  ground.changes_since = std::move(material.changes_since);
  ground.promotion_questions = std::move(asked.all);
  ground.questions_for_a_reason = std::move(asked.for_a_reason);
  return ground;
}

}  // namespace

Awaitable<Result<std::vector<RunGround>>> ProvenanceService::grounds_of_runs(
    std::vector<RunId> runs) {
  co_return co_await reader_.call(
      [](Store& store, const std::vector<RunId>& asked) -> Result<std::vector<RunGround>> {
        DRIFTWISE_TRY(const auto all, store.extensions().corrections());
        std::vector<RunGround> grounds;
        for (const RunId run : asked) {
          DRIFTWISE_TRY(auto ground, ground_of(store, run, all));
          grounds.push_back(std::move(ground));
        }
        return grounds;
      },
      std::move(runs));
}

Awaitable<Result<ModelGround>> ProvenanceService::ground_of_model(ModelId id) {
  co_return co_await reader_.call([id, present = &description_, clock = &clock_](Store& store) {
    return ground_of(store, id, *present, *clock);
  });
}

}  // namespace driftwise::application
