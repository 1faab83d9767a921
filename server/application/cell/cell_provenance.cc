// What data rest on: cell files and corrections.

#include <fmt/format.h>

#include <algorithm>

#include "server/application/cell/cell_application.h"
#include "server/application/datasets/extension_preview.h"
#include "server/application/provenance/promotion_questions.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/formats/cell_file/cell_file.h"
#include "server/formats/diagnosis/amendment_json.h"
#include "server/formats/model/model_json.h"

namespace driftwise::application {
namespace {

constexpr const char* kAnyPath = "cell.toml";  // paths inside the file do not matter here

// The description of a configuration in the record: the present one, or its text read again.
std::optional<CellDescription> description_of(Store& store, const std::string& hash,
                                              const CellDescription& present) {
  if (hash == present.hash) return present;
  const auto text = store.configurations().text(hash);
  if (!text) return std::nullopt;
  auto cell = formats::parse_cell_file(*text, kAnyPath, present.kinds);
  if (!cell) return std::nullopt;
  return std::move(*cell);
}

Result<RunGround> ground_of(Store& store, RunId run,
                            const std::vector<CorrectionRecord>& corrections) {
  RunGround ground;
  DRIFTWISE_TRY(auto used, store.configurations().of_run(run));
  ground.configurations = std::move(used);
  for (const auto& correction : corrections) {
    if (!correction.in_force()) continue;
    const auto amendment = formats::read_amendment_json(correction.json);
    if (!amendment || !concerns(*amendment, run)) continue;
    auto& mine = ground.corrections.emplace_back(correction);
    std::erase_if(mine.changes, [run](const LengthChange& change) { return change.run != run; });
  }
  return ground;
}

Result<ModelGround> ground_of(Store& store, ModelId id, const CellDescription& present) {
  DRIFTWISE_TRY(const auto record, store.models().model(id));
  DRIFTWISE_TRY(const auto model, formats::read_model_json(record.json));
  ModelGround ground;
  ground.present_hash = present.hash;
  for (const RunId run : model.lineage.runs) {
    DRIFTWISE_TRY(const auto used, store.configurations().of_run(run));
    for (const auto& one : used)
      if (one.from <= record.created &&
          std::ranges::find(ground.configurations, one.hash, &UsedConfiguration::hash) ==
              ground.configurations.end())
        ground.configurations.push_back(one);
  }
  std::ranges::stable_sort(ground.configurations, {}, &UsedConfiguration::from);
  if (!ground.configurations.empty()) {
    const auto& last = ground.configurations.back().hash;
    ground.measured_under = description_of(store, last, present);
    if (last != present.hash) {
      DRIFTWISE_TRY(const auto text, store.configurations().text(last));
      ground.changes_since = formats::cell_file_difference(text, present);
    }
  }
  DRIFTWISE_TRY(const auto corrections, store.diagnoses().corrections());
  for (const auto& correction : corrections)
    if (std::ranges::find(record.corrections, correction.id) != record.corrections.end()) {
      auto& mine = ground.corrections.emplace_back(correction);
      std::erase_if(mine.changes, [&model](const LengthChange& change) {
        return std::ranges::find(model.lineage.runs, change.run) == model.lineage.runs.end();
      });
    }
  for (auto& questions :
       {temperature_questions(model, present), correction_questions(ground.corrections),
        configuration_questions(model, ground.changes_since)})
    ground.promotion_questions.insert(ground.promotion_questions.end(), questions.begin(),
                                      questions.end());
  return ground;
}

}  // namespace

Awaitable<Result<std::vector<ConfigurationStart>>> CellApplication::configurations(int limit) {
  co_return co_await reader_.configurations().starts(limit);
}

Awaitable<Result<ConfigurationView>> CellApplication::configuration(std::string hash,
                                                                    std::string compare_hash) {
  if (hash.empty()) hash = description_.hash;
  if (compare_hash.empty()) compare_hash = description_.hash;
  co_return co_await reader_.call(
      [present = &description_](Store& store, const std::string& shown,
                                const std::string& other) -> Result<ConfigurationView> {
        DRIFTWISE_TRY(auto text, store.configurations().text(shown));
        ConfigurationView view{shown, std::move(text), other, {}};
        if (shown == other) return view;
        DRIFTWISE_RETURN_IF_ERROR(store.configurations().text(other));
        const auto compared = description_of(store, other, *present);
        if (!compared)
          return fail(
              ErrorCode::failed_precondition, reasons::kOldConfiguration,
              fmt::format("configuration {} cannot be read by this program: it can be shown, not "
                          "compared with",
                          other));
        view.changes = formats::cell_file_difference(view.text, *compared);
        return view;
      },
      hash, compare_hash);
}

Awaitable<Result<ConfigurationStart>> CellApplication::accept_configuration(Caller caller,
                                                                            std::string hash,
                                                                            std::string note) {
  if (!configuration_.asks())
    co_return fail(ErrorCode::failed_precondition, reasons::kNoQuestion,
                   fmt::format("configuration {} puts no question: there is nothing to accept",
                               description_.hash));
  if (hash != description_.hash)
    co_return fail(ErrorCode::failed_precondition, reasons::kOtherConfiguration,
                   fmt::format("configuration '{}' was seen, {} is in force: look at the present "
                               "difference ('driftwise configuration show')",
                               hash, description_.hash));
  const auto* run = engine_.record();
  const bool continues = run && !waits_for_configuration(*run).empty();
  std::optional<RunId> continued;
  if (continues) continued = run->id;
  const auto at = clock_->now().utc;
  auto accepted = co_await writer_.configurations().accept(configuration_.start().id, at,
                                                           caller.name, note, continued);
  if (!accepted) co_return accepted;
  configuration_.answered(*accepted);
  events_.record(caller, "configuration.accepted",
                 fmt::format("{} accepted configuration {} after {}{}{}", caller.name, hash,
                             accepted->before_hash, note.empty() ? "" : ": ", note));
  serving_.look_again();
  // A pause or a stop of a person's stays; whoever resumes the run ends it.
  if (auto* control = engine_.control();
      control && control->hold().kind == RunHold::Kind::configuration && continued)
    control->resume();
  co_return accepted;
}

// Why a run that was begun under another cell file may not go on; empty: it may.
std::string CellApplication::waits_for_configuration(const RunRecord& run) const {
  if (!configuration_.asks() || run.created >= configuration_.start().at.utc) return {};
  return configuration_.question();
}

Awaitable<Result<std::vector<RunGround>>> CellApplication::grounds_of_runs(
    std::vector<RunId> runs) {
  co_return co_await reader_.call(
      [](Store& store, const std::vector<RunId>& asked) -> Result<std::vector<RunGround>> {
        DRIFTWISE_TRY(const auto all, store.diagnoses().corrections());
        std::vector<RunGround> grounds;
        for (const RunId run : asked) {
          DRIFTWISE_TRY(auto ground, ground_of(store, run, all));
          grounds.push_back(std::move(ground));
        }
        return grounds;
      },
      std::move(runs));
}

Awaitable<Result<ModelGround>> CellApplication::ground_of_model(ModelId id) {
  co_return co_await reader_.call(
      [id, present = &description_](Store& store) { return ground_of(store, id, *present); });
}

Awaitable<Result<std::vector<CorrectionRecord>>> CellApplication::corrections() {
  co_return co_await reader_.diagnoses().corrections();
}

}  // namespace driftwise::application
